// Where the data do not decide between sets of effects, one of them is in the estimate: what the others would make of
// its parameters is an error of that choice. Each refitted set k has a share of the probability,
//
//   T = sum over the others of p_k d_k d_k',   d_k = x_k - x - G (h_k - h)
//
// about the estimate x (Draper 1995, "Assessment and propagation of model uncertainty"; Hoeting et al. 1999, "Bayesian
// model averaging"). h are held: each fit puts them where it fits best, and what x follows of that by its slopes G is
// the same robot (held_influence.h, which counts what h is uncertain by).
#pragma once

#include <string>
#include <vector>

#include "estimator/agreement/between_parts.h"
#include "estimator/diagnosis/diagnosed_model.h"

namespace sagitta {

// A set that holds other effects than the one that is named.
struct RivalSet {
  double probability = 0.0;
  std::vector<EffectSpec> instead;  // of its own
  ParameterSet parameters;          // fitted with it
};

// T of the coordinates behind the estimate's covariance; of an effect that a rival has not, no other value is known.
// Not known where no rival has a share. probability: of the set that the estimate holds.
BetweenParts ErrorOfChoice(const Estimate& estimate, double probability, const std::vector<RivalSet>& rivals);

// The effects of each rival with more than that share of the probability of all.
std::vector<std::vector<EffectSpec>> WhatRivalsHold(double probability, const std::vector<RivalSet>& rivals,
                                                    double share);

// Adds `more`; each coordinate's degrees of freedom are those of the sum.
void AddTo(const BetweenParts& more, BetweenParts* between);

}  // namespace sagitta
