// The columns of a DH table as text.
#pragma once

#include <string>
#include <vector>

#include "problems/io/import/text_table.h"

namespace sagitta {

// What a column of a DH table can hold. kR: along x or along z (SetLengths); kOffset: of the joint's value;
// kThetaOffset: of theta.
enum class DhColumn {
  kA,
  kR,
  kAlpha,
  kD,
  kTheta,
  kThetaOffset,
  kOffset,
  kBeta,
  kName,
  kType,
  kSign,
  kMin,
  kMax,
  kOther
};

bool IsLength(DhColumn column);
bool IsAngle(DhColumn column);

// "alpha_{i-1} [deg]": by the name without its index and its unit. Indices one behind the joint's are Craig's.
DhColumn ColumnOf(const std::string& header, bool* is_previous);

// a, alpha and d are there.
bool IsDhHeader(const std::vector<std::string>& header);

// Of every column. Throws InputError where two hold the same, or where one that is not known may describe the
// kinematics: a length or an angle, a word for it.
std::vector<DhColumn> DhColumnsOf(const TextTable& table, bool* has_previous);

// r is along x in place of a, and d along z (Denavit and Hartenberg's d, theta, r, alpha); in Khalil's notation d is
// along x and r along z (Khalil and Kleinfinger 1986: alpha, d, theta, r). is_khalil: the file says so. Returns whether
// there is an r: in a modified table it could be either.
bool SetLengths(bool is_khalil, std::vector<DhColumn>* columns);

// The names of the columns that are left out, "" where there are none.
std::string ColumnsNotRead(const TextTable& table, const std::vector<DhColumn>& columns);

}  // namespace sagitta
