// SPDX-License-Identifier: MIT
#include "state_copies.h"

#include <phymul/error.h>

#include <cstring>
#include <limits>

#include "gl/objects/handle.h"

namespace phymul::gl {
namespace {

struct Rows {
  Int4 events;
  Float4 largest;
};

}  // namespace

void ReportCopy::begin(std::size_t more_rows) {
  const bool fits = buffer_ && more_rows == more_.size();
  more_.resize(more_rows);
  if (!buffer_) buffer_ = Handle<BufferKind>(one_name(glGenBuffers));
  glBindBuffer(GL_PIXEL_PACK_BUFFER, *buffer_);
  if (!fits) glBufferData(GL_PIXEL_PACK_BUFFER, bytes(), nullptr, GL_STREAM_READ);
}

GLsizeiptr ReportCopy::bytes() const {
  return static_cast<GLsizeiptr>(sizeof(Rows) + more_.size() * sizeof(Float4));
}

BatchReport ReportCopy::end() {
  Rows rows{};
  read_buffer(GL_PIXEL_PACK_BUFFER, bytes(), [&](const void* from) {
    std::memcpy(&rows, from, sizeof rows);
    if (!more_.empty())
      std::memcpy(more_.data(), static_cast<const char*>(from) + sizeof rows, more_.size() * sizeof(Float4));
  });
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  return {rows.events, rows.largest};
}

BatchReport::BatchReport(const Int4& events, const Float4& largest)
    : max_speed(largest[0]), max_acceleration(largest[1]), max_force(largest[2]), max_displacement(largest[3]) {
  constexpr std::int32_t never = std::numeric_limits<std::int32_t>::max();
  if (events[0] < 1) throw Error(ErrorCode::device, "the device gave no report of its steps");
  cut = events[0] == never - 1;
  if (events[0] < never - 1) {
    runaway_step = events[0];
    particle = events[1];
  }
  first_unquiet = events[2] == never ? 0 : events[2];
  last_unquiet = events[3];
}

void BatchReport::see_volumes(std::span<const Float4> roots) {
  for (std::size_t row = 0; row < roots.size(); ++row) {
    const int step = static_cast<int>(roots[row][1]);
    if (step == 0 || (lost_step > 0 && lost_step <= step)) continue;
    lost_step = step;
    lost_volume = static_cast<int>(row);
  }
}

void pack_state(const VecList& rest, const State& state, PlaceOf place_of, Float4* displacement, Float4* velocity) {
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const std::size_t row = place_of.empty() ? i : static_cast<std::size_t>(place_of[i]);
    for (int axis = 0; axis < 3; ++axis) {
      displacement[row][axis] = static_cast<float>(state.position[i][axis] - rest[i][axis]);
      velocity[row][axis] = static_cast<float>(state.velocity[i][axis]);
    }
  }
}

void unpack_state(const Float4* displacement, const Float4* velocity, const VecList& rest, PlaceOf place_of,
                  State& state) {
  state.position.resize(rest.size());
  state.velocity.resize(rest.size());
  for (std::size_t i = 0; i < rest.size(); ++i) {
    const std::size_t row = place_of.empty() ? i : static_cast<std::size_t>(place_of[i]);
    for (int axis = 0; axis < 3; ++axis) {
      state.position[i][axis] = rest[i][axis] + static_cast<double>(displacement[row][axis]);
      state.velocity[i][axis] = static_cast<double>(velocity[row][axis]);
    }
  }
}

int StatePairs::free_pair() const {
  int pair = 0;
  while (pair == current_ || pair == checkpoint_) ++pair;
  return pair;
}

StateCopies::~StateCopies() {
  clear();
  glDeleteBuffers(static_cast<GLsizei>(spare_.size()), spare_.data());
}

void StateCopies::drop(Copy& copy) {
  glDeleteSync(copy.fence);
  spare_.push_back(copy.buffer);
}

void StateCopies::clear() {
  for (Copy& copy : on_their_way_) drop(copy);
  on_their_way_.clear();
}

void StateCopies::request(std::size_t rows, const State& header, const std::function<void()>& fill) {
  if (on_their_way_.size() == most) {
    drop(on_their_way_.back());
    on_their_way_.pop_back();
  }
  Copy copy{.rows = rows, .header = header};
  if (spare_.empty()) {
    glGenBuffers(1, &copy.buffer);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, copy.buffer);
    const auto bytes = static_cast<GLsizeiptr>(2 * rows * sizeof(Float4));
    glBufferData(GL_PIXEL_PACK_BUFFER, bytes, nullptr, GL_STREAM_READ);
  } else {
    copy.buffer = spare_.back();
    spare_.pop_back();
    glBindBuffer(GL_PIXEL_PACK_BUFFER, copy.buffer);
  }
  fill();
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  copy.fence = glFenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0);
  glFlush();  // a fence that is never sent never comes
  on_their_way_.push_back(std::move(copy));
}

bool StateCopies::collect(const VecList& rest, PlaceOf place_of, State& state) {
  if (on_their_way_.empty()) return false;
  Copy& copy = on_their_way_.front();
  const GLenum answer = glClientWaitSync(copy.fence, 0, 0);
  if (answer != GL_ALREADY_SIGNALED && answer != GL_CONDITION_SATISFIED) return false;
  glBindBuffer(GL_PIXEL_PACK_BUFFER, copy.buffer);
  const auto bytes = static_cast<GLsizeiptr>(2 * copy.rows * sizeof(Float4));
  const bool came = read_buffer(GL_PIXEL_PACK_BUFFER, bytes, [&](const void* from) {
    const auto* rows = static_cast<const Float4*>(from);
    copy.header.position.swap(state.position);  // whose memory is reused
    copy.header.velocity.swap(state.velocity);
    state = std::move(copy.header);
    unpack_state(rows, rows + copy.rows, rest, place_of, state);
  });
  glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
  drop(copy);
  on_their_way_.pop_front();
  return came;
}

}  // namespace phymul::gl
