// SPDX-License-Identifier: MIT
#include "gl/fragment_copies.h"

namespace phymul::gl {

FragmentCopies::~FragmentCopies() {
  clear();
  glDeleteBuffers(static_cast<GLsizei>(spare_.size()), spare_.data());
}

void FragmentCopies::drop(Copy& copy) {
  glDeleteSync(copy.fence);
  spare_.push_back(copy.buffer);
}

void FragmentCopies::clear() {
  for (Copy& copy : on_their_way_) drop(copy);
  on_their_way_.clear();
}

void FragmentCopies::request(const FragmentState& state, double time) {
  if (on_their_way_.size() == most) {
    drop(on_their_way_.back());
    on_their_way_.pop_back();
  }
  Copy copy;
  copy.time = time;
  copy.bytes = static_cast<std::size_t>(state.current().shape().texels()) * sizeof(Float4);
  if (spare_.empty()) {
    glGenBuffers(1, &copy.buffer);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, copy.buffer);
    glBufferData(GL_PIXEL_PACK_BUFFER, static_cast<GLsizeiptr>(2 * copy.bytes), nullptr, GL_STREAM_READ);
  } else {
    copy.buffer = spare_.back();
    spare_.pop_back();
    glBindBuffer(GL_PIXEL_PACK_BUFFER, copy.buffer);
  }
  state.current().read(0, GL_RGBA, GL_FLOAT, nullptr);
  state.current().read(1, GL_RGBA, GL_FLOAT, reinterpret_cast<void*>(copy.bytes));  // an offset in the buffer
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  copy.fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  glFlush();  // a fence that is never sent never comes
  on_their_way_.push_back(copy);
}

bool FragmentCopies::collect(const VecList& rest, State& state) {
  if (on_their_way_.empty()) return false;
  Copy& copy = on_their_way_.front();
  const GLenum answer = glClientWaitSync(copy.fence, 0, 0);
  if (answer != GL_ALREADY_SIGNALED && answer != GL_CONDITION_SATISFIED) return false;
  glBindBuffer(GL_PIXEL_PACK_BUFFER, copy.buffer);
  const auto* rows = static_cast<const Float4*>(
      glMapBufferRange(GL_PIXEL_PACK_BUFFER, 0, static_cast<GLsizeiptr>(2 * copy.bytes), GL_MAP_READ_BIT));
  if (rows) {
    unpack_state(rows, rows + copy.bytes / sizeof(Float4), rest, state);
    state.time = copy.time;
    glUnmapBuffer(GL_PIXEL_PACK_BUFFER);
  }
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  drop(copy);
  on_their_way_.pop_front();
  return rows != nullptr;
}

}  // namespace phymul::gl
