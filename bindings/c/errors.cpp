// SPDX-License-Identifier: MIT
#include <algorithm>
#include <new>

#include "handles.h"

namespace phymul::c {

std::string& last_error() {
  thread_local std::string text;
  return text;
}

namespace {

phymul_status fail(phymul_status status, const char* text) noexcept {
  try {
    last_error() = text;
  } catch (...) {
    last_error().clear();  // no memory for the text
  }
  return status;
}

phymul_status status_of(ErrorCode code) noexcept {
  switch (code) {
    case ErrorCode::invalid_argument:
      return PHYMUL_INVALID_ARGUMENT;
    case ErrorCode::unknown_name:
      return PHYMUL_UNKNOWN_NAME;
    case ErrorCode::file_access:
      return PHYMUL_FILE_ACCESS;
    case ErrorCode::file_format:
      return PHYMUL_FILE_FORMAT;
    case ErrorCode::invalid_model:
      return PHYMUL_INVALID_MODEL;
    case ErrorCode::not_supported:
      return PHYMUL_NOT_SUPPORTED;
    case ErrorCode::device:
      return PHYMUL_DEVICE;
    case ErrorCode::out_of_memory:
      return PHYMUL_OUT_OF_MEMORY;
  }
  return PHYMUL_INTERNAL;
}

}  // namespace

phymul_status status_of_exception() noexcept {
  try {
    throw;
  } catch (const Error& error) {
    return fail(status_of(error.code()), error.what());
  } catch (const Failure& failure) {
    return fail(failure.status, failure.message.c_str());
  } catch (const std::bad_alloc&) {
    return fail(PHYMUL_OUT_OF_MEMORY, "there is no memory left");
  } catch (const std::exception& error) {
    return fail(PHYMUL_INTERNAL, error.what());
  } catch (...) {
    return fail(PHYMUL_INTERNAL, "an exception of unknown type");
  }
}

VecList vectors(const double* data, int32_t count, const char* what) {
  if (count < 0) list(data, count, what);
  need(data, what);
  VecList result(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = {data[3 * i], data[3 * i + 1], data[3 * i + 2]};
  return result;
}

std::vector<std::array<Index, 3>> triples(const int32_t* data, int32_t count, const char* what) {
  list(data, count, what);
  std::vector<std::array<Index, 3>> result(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < result.size(); ++i) std::copy_n(data + 3 * i, 3, result[i].begin());
  return result;
}

void require_kind(int32_t kind, int32_t first, int32_t count, const char* what) {
  if (kind < first || kind >= first + count)
    throw Error(std::string("expected ") + what + " from " + std::to_string(first) + " to " +
                std::to_string(first + count - 1) + ", got " + std::to_string(kind));
}

void require_name(const char* name, const char* what) {
  if (need(name, what) == '\0' || std::strchr(name, '\n'))
    throw Error(std::string("expected ") + what + " of one line that is not empty");
}

std::string lines(const std::vector<std::string>& sentences) {
  std::string text;
  for (const std::string& sentence : sentences) text += (text.empty() ? "" : "\n") + sentence;
  return text;
}

}  // namespace phymul::c

using namespace phymul::c;

const char* phymul_last_error() {
  return last_error().c_str();
}

const char* phymul_version() {
  return PHYMUL_VERSION;
}

phymul_status phymul_backends(const char** names) {
  return guarded([&] {
    static const std::string all = lines(phymul::backend_names());
    need(names, "a place for the names") = all.c_str();
  });
}
