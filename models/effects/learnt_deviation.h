// Sizes of a deviation that has no name, and the links that grow: shared by the effects that are learnt and by the
// columns that find them.
#pragma once

#include <string>
#include <vector>

#include "models/chain.h"
#include "models/effects/effect.h"

namespace sagitta {

// Those of a harmonic (joint_harmonic.cc), of what moves a station or a marker, of thermal growth (thermal_growth.cc).
constexpr double kTypicalTurn = 75e-6;         // rad
constexpr double kTypicalTravel = 50e-6;       // m, of a joint that slides
constexpr double kTypicalMovement = 30e-6;     // m
constexpr double kTypicalStationTurn = 15e-6;  // rad: what that makes at 2 m
constexpr double kTypicalScale = 10e-6;        // of a station's readings: 10 K or 35 hPa of wrong air (Ciddor 1996)
constexpr double kTypicalPlateTurn = 150e-6;   // rad: what that makes at 0.2 m
constexpr double kTypicalLoadShift = 20e-3;    // m (load_com.cc)
constexpr double kTypicalPull = 3.0;           // kg: what hose packages and tool balancers weigh or lift is 1 to 10 kg
constexpr double kTypicalGrowth = 50e-6;       // of a link's length: 5 K of steel or 2 K of aluminium

// Transforms that are lengths of the arm, by the link that they are on: 0 the foot, j + 1 after the joint j. The same
// of a robot before and after its errors were identified.
std::vector<std::vector<int>> LengthsByLink(const Chain& chain);

// Whether a joint, by its name, is one that slides.
bool Slides(const Robot& robot, const std::string& joint);
// SI of a file's unit of a joint: deg or mm.
double UnitOfJoint(const Robot& robot, const std::string& joint);
// A weight of a deviation of the target: an angle, or a length of one that slides.
EffectParameter WeightOfJoint(const Robot& robot, const EffectSpec& spec, const std::string& name);

// Which way is down, as the settings down_x, down_y, down_z state it: in the base frame, of any length.
Vector3<double> DownOf(const EffectSpec& spec);

// A function of time by ramps, not by bumps (bump.h).
bool IsOfRamps(const EffectSpec& spec);

// What all learnt effects say of themselves.
EffectDefinition Empirical(EffectDefinition effect);

}  // namespace sagitta
