// SPDX-License-Identifier: MIT
#include "fragment_contact_passes.h"

#include <utility>

#include "gl/solver/body_kind.h"

namespace phymul::gl {

FragmentContactPasses::FragmentContactPasses(const ShaderLibrary& library) {
  using Defines = std::vector<std::pair<std::string, int>>;
  const ShaderFiles common{"dialect/dialect_fragment.glsl", "dialect/kernel_language.glsl",
                           "contact/contact_surfaces.glsl"};
  const auto compiled = [&](ShaderFiles files, Defines defines = {}) {
    return Pass(library, {.files = joined({common, std::move(files)}), .defines = std::move(defines)});
  };
  surfaces_ = compiled({"tools/pushed_tables.glsl", "contact/contact_surface_pass.glsl"});
  const std::pair<std::string, int> branch{"ROWS_TO_ONE", FragmentContacts::branch};
  mean_first_ = compiled({"contact/contact_speed_pass.glsl"}, {branch, {"FIRST", 1}});
  mean_ = compiled({"contact/contact_speed_pass.glsl"}, {branch});
  fastest_first_ = compiled({"contact/contact_speed_pass.glsl"}, {branch, {"FIRST", 1}, {"FASTEST", 1}});
  fastest_ = compiled({"contact/contact_speed_pass.glsl"}, {branch, {"FASTEST", 1}});
  triangle_boxes_ = compiled({"contact/contact_tree.glsl", "contact/contact_box_pass.glsl"});
  search_ = compiled({"tools/closest_point.glsl", "contact/contact_tree.glsl", "contact/contact_range.glsl",
                      "contact/contact_nearest.glsl", "contact/contact_search_pass.glsl"});
  corner_boxes_ = compiled({"contact/contact_tree.glsl", "contact/contact_box_pass.glsl"}, {{"MEETINGS", 1}});
  next_ = compiled({"contact/contact_tree.glsl", "contact/contact_lists.glsl", "contact/contact_next_pass.glsl"});
  start_ = compiled({"contact/contact_tree.glsl", "contact/contact_lists.glsl", "contact/contact_sweeps.glsl",
                     "contact/contact_start_pass.glsl"});
  phase_ = compiled({"contact/contact_sweeps.glsl", "contact/contact_law.glsl", "contact/contact_phase_pass.glsl"});
  part_ = compiled({"tools/pushed_tables.glsl", "contact/contact_sweeps.glsl", "contact/contact_law.glsl",
                    "contact/contact_part_pass.glsl"});
  told_first_ = compiled({"contact/contact_sweeps.glsl", "contact/contact_report_pass.glsl"}, {branch, {"FIRST", 1}});
  told_ = compiled({"contact/contact_sweeps.glsl", "contact/contact_report_pass.glsl"}, {branch});
}

void FragmentContactPasses::set_contacts(FragmentContacts& contacts) {
  contacts_ = &contacts;
  for (Pass* const pass : {&surfaces_, &mean_first_, &mean_, &fastest_first_, &fastest_, &triangle_boxes_, &search_,
                           &corner_boxes_, &next_, &start_, &phase_, &part_}) {
    contacts.constants.for_each([pass](const char* name, auto value) { pass->set(name, value); });
    contacts.bind_surfaces(*pass);
  }
  for (Pass* const pass : {&corner_boxes_, &next_, &start_, &phase_, &part_}) contacts.bind_meetings(*pass);
  for (Pass* const pass : {&triangle_boxes_, &search_}) contacts.triangles.bind_tables(*pass);
  for (Pass* const pass : {&corner_boxes_, &next_, &start_}) contacts.corners.bind_tables(*pass);
  for (Pass* const pass : {&surfaces_, &part_}) contacts.free.bind(*pass);
  fastest_first_.input("mean_velocity", contacts.mean.result());
  search_.input("fastest", contacts.fastest.result());
  part_.input("surface_rows", contacts.surface_rows());
  surfaces_.set_rows(contacts.moved, contacts.particles());
  search_.set_rows(contacts.who, contacts.meetings());
  next_.set_rows(contacts.next_entries, 4 * contacts.meetings());
  for (Pass* const pass : {&start_, &phase_})
    pass->set_rows(contacts.sweep_rows(), contacts.particles() + contacts.meetings());
  part_.set_rows(contacts.pushed_force, static_cast<int>(contacts.pushed_force.rows()));
}

void FragmentContactPasses::set_free(const OpenStep& open) {
  for (Pass* const pass : {&surfaces_, &part_}) open.bind(*pass);
}

void FragmentContactPasses::set_step(double dt) {
  search_.set("dt", static_cast<float>(dt));
  for (Pass* const pass : {&phase_, &part_}) pass->set("inverse_dt", static_cast<float>(1.0 / dt));
}

void FragmentContactPasses::act(const Texture& displacement, int batch_step) {
  surfaces_.input("displacement", displacement);
  surfaces_.draw(contacts_->surface_target);
  contacts_->mean.draw(mean_first_, mean_);
  contacts_->fastest.draw(fastest_first_, fastest_);
  contacts_->triangles.measure(triangle_boxes_);
  contacts_->triangles.bind_boxes(search_);
  search_.draw(contacts_->meeting_target);
  contacts_->corners.measure(corner_boxes_);
  for (Pass* const pass : {&next_, &start_}) contacts_->corners.bind_boxes(*pass);
  next_.draw(contacts_->next_target);
  press(batch_step);
  contacts_->bind_sweeps(part_);
  part_.draw(contacts_->pushed_target);
}

void FragmentContactPasses::press(int batch_step) {
  contacts_->bind_sweeps(start_);
  start_.set("batch_step", batch_step);
  start_.draw(contacts_->next_sweeps());
  for (int phase = 1; phase <= contacts_->phases(); ++phase) {
    contacts_->bind_sweeps(phase_);
    phase_.set("phase", phase);
    phase_.draw(contacts_->next_sweeps());
  }
}

void FragmentContactPasses::sum(int last_step) {
  contacts_->bind_sweeps(told_first_);
  told_first_.set("last_step", last_step);
  contacts_->told.draw(told_first_, told_);
}

}  // namespace phymul::gl
