// SPDX-License-Identifier: MIT
#include "storage_rows.h"

namespace phymul::gl {

std::int64_t StorageRows::take(const std::string& name, std::int64_t rows) {
  const std::int64_t first = end_;
  end_ += rows;
  if (!name.empty()) note(name, static_cast<int>(first));
  return first;
}

std::int64_t StorageRows::take_words(const std::string& name, std::int64_t words) {
  const std::int64_t first = 4 * take({}, rows_of(4 * words));
  note(name, static_cast<int>(first));
  return first;
}

void StorageRows::send(StorageBuffer& buffer) {
  for (const Content& content : contents_) buffer.write(content.first_byte, content.data, content.bytes);
  contents_.clear();
  kept_.clear();
}

void StorageRows::place(Kernel& kernel) const {
  for (const Uniform& uniform : uniforms_) {
    std::visit([&](auto value) { kernel.set(uniform.name.c_str(), value); }, uniform.value);
  }
}

}  // namespace phymul::gl
