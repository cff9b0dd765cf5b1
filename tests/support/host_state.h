// SPDX-License-Identifier: MIT
//
// The state of a host's context: set to values that no fresh context has, noted, and compared.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gl/context/context_info.h"
#include "gl/context/gl_api.h"

namespace phymul::test {

/// Every value that glGet* tells and a pass could touch, by name.
using HostState = std::map<std::string, std::vector<double>>;
HostState host_state(const gl::ContextInfo& info);

/// Names whose values differ, with both.
std::string differences(const HostState& before, const HostState& after);

/// Objects of a host, all bound, and every switch and number set against what a pass needs.
class HostileHost {
 public:
  explicit HostileHost(const gl::ContextInfo& info);
  ~HostileHost();
  HostileHost(const HostileHost&) = delete;
  HostileHost& operator=(const HostileHost&) = delete;

 private:
  void bind_objects();
  void bind_textures();
  void set_numbers();
  void set_switches(bool on);

  const gl::ContextInfo& info_;
  GLuint program_ = 0, vertex_array_ = 0, renderbuffer_ = 0;
  std::vector<GLuint> framebuffers_, buffers_, textures_, samplers_;
};

/// What a careless step would leave behind.
void leave_a_mess();

/// Sends a texture of 4 x 2 x 2, draws over its second layer and reads both back; true where they are as they should.
bool draws_well(const gl::ContextInfo& info);

}  // namespace phymul::test
