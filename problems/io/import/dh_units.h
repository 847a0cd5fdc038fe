// The units of a DH table as text: in the header, in a cell, or by the size of the numbers.
#pragma once

#include <vector>

#include "models/chain.h"
#include "problems/io/import/dh_columns.h"
#include "problems/io/import/expressions.h"
#include "problems/io/import/robot_reading.h"
#include "problems/io/units.h"

namespace sagitta {

class DhUnits {
 public:
  // What is guessed or understood goes into `reading`. Throws InputError where a unit does not fit its column or
  // cannot be decided.
  DhUnits(const TextTable& table, const std::vector<DhColumn>& columns, RobotReading* reading);

  // A cell of a length or an angle in m or rad; InputError where no robot has it.
  double ToSi(const TextTable::Row& row, size_t c, const TypedNumber& number) const;

  // The limits of every row's joint.
  void ReadLimits(std::vector<Joint>* joints, RobotReading* reading) const;

 private:
  [[noreturn]] void Fail(const TextTable::Row& row, size_t c, const std::string& what, const std::string& hint) const;
  bool IsLimit(size_t c) const { return columns_[c] == DhColumn::kMin || columns_[c] == DhColumn::kMax; }
  void ReadHeader(size_t c);
  void GuessLengths(RobotReading* reading);
  void GuessAngles(RobotReading* reading);
  void CheckThousands() const;
  std::optional<double> Thousands(const std::string& cell) const;
  std::optional<TypedNumber> ConstantOf(const std::string& cell) const;
  std::optional<TypedNumber> LimitOf(const TextTable::Row& row, size_t c) const;
  bool StatesNone(const TextTable::Row& row) const;
  const Unit& UnitOfLimits(const std::vector<Joint>& joints, JointType type, RobotReading* reading) const;

  const TextTable& table_;
  const std::vector<DhColumn>& columns_;
  std::vector<const Unit*> units_;  // nullptr: not stated
  AnglesWithoutUnit angles_;
  const Unit* length_ = nullptr;  // of limits without a unit: of d where it has one, else guessed, else of a
  bool angles_are_in_rad_ = false;
};

}  // namespace sagitta
