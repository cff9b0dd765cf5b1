// SPDX-License-Identifier: MIT
//
// What a plan says to people.
#pragma once

#include <phymul/plan.h>

#include <string>

namespace phymul {

/// `coarser`: the next coarser body, which misses the error; null: there is none.
std::string reason_of_choice(const Plan& plan, const PlanTrial* coarser);

/// `ended`: why no finer body than `finest` was tried.
std::string reason_of_refusal(const Plan& plan, const PlanTrial& finest, const std::string& ended);

/// "9.1 mm, 425 particles, cpu with 2 threads, step 0.5".
std::string describe(const PlanTrial& trial);

/// What can be had instead, a sentence each; empty if nothing can.
std::string describe_offers(const Plan& plan);

}  // namespace phymul
