// The languages of robot programs, and all in which they differ but for their readers: one row of a table each.
#pragma once

#include <set>
#include <string>
#include <vector>

namespace sagitta {

struct RobotProgram;  // robot_program.h
struct CallPatterns;  // calls_elsewhere.h

enum class ProgramDialect {
  kKrl,
  kRapid,
  kUrScript,
  kFanuc,
  kCount  // how many there are; no dialect itself
};

// How a pose is written: lengths, and a rotation of three angles, a vector or a quaternion.
enum class PoseNotation {
  kAbcDegrees,           // KRL: x y z A B C, R = Rz(A) Ry(B) Rx(C)
  kWprDegrees,           // FANUC: x y z W P R, R = Rz(R) Ry(P) Rx(W)
  kQuaternion,           // RAPID: x y z, scalar first
  kRotationVectorMetres  // UR: x y z in m, vector in rad
};

// What differs between dialects.
struct DialectTraits {
  const char* name;                  // "KUKA KRL"
  const char* maker;                 // "KUKA"
  std::vector<const char*> endings;  // of files, in small letters: ".src"
  PoseNotation notation;
  bool joints_in_rad;          // in the text; else in deg
  bool names_have_case;        // p1 and P1 are two points
  bool turns_of_three_joints;  // poses count turns of three joints, and the file does not say of which
  void (*read)(int joints, RobotProgram* program);
  const CallPatterns& (*calls)();
  // What stands where a routine could be called and calls none, in capitals unless names have case.
  const std::set<std::string>& (*words)();
};

// The row of a dialect.
const DialectTraits& TraitsOf(ProgramDialect dialect);

// By the ending of a file's name, in whatever case. Throws InputError at the file for another.
ProgramDialect DialectOfFile(const std::string& path);

}  // namespace sagitta
