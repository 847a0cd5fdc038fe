// Numbers as people type them into tables: 90, -pi/2, 0.5*pi, 90°, q1 + 90, θ2-pi/2.
#pragma once

#include <optional>
#include <string>

namespace sagitta {

// A number that may be a multiple or a fraction of pi; `uses_pi`, `is_degrees` (a
// degree sign) say in which unit it can only be.
struct TypedNumber {
  double value = 0.0;
  bool uses_pi = false;
  bool is_degrees = false;
};
std::optional<TypedNumber> ParseTypedNumber(const std::string& text, bool decimal_comma = false);

// A joint variable (letters, then a number: q1, -q2, θ3, theta_4, q1*) with a constant.
struct JointExpression {
  int index = 0;  // the number after the letters
  double sign = 1.0;
  TypedNumber offset;
};
std::optional<JointExpression> ParseJointExpression(const std::string& text, bool decimal_comma = false);

// Angles of a text that does not state their unit, together: the unit of all, or of each where there is no doubt. With
// pi it is rad; with a degree sign, or beyond a full turn, deg.
class AnglesWithoutUnit {
 public:
  void Add(const TypedNumber& number);

  // kEach: with pi in rad, the others in deg.
  enum class Unit { kRad, kDeg, kEach };
  Unit unit() const;
  // Nothing but the size of the numbers says so.
  bool is_guess() const;
  // A number of which nothing says in which of two units it is, while others are in either; 1.5708 where all are in
  // deg.
  bool IsUndecided(const TypedNumber& number) const;
  double ToRad(const TypedNumber& number) const;
  double largest() const { return largest_; }

 private:
  bool uses_pi_ = false, is_degrees_ = false, all_whole_ = true, any_small_ = false;
  double largest_ = 0.0;  // without pi
};

}  // namespace sagitta
