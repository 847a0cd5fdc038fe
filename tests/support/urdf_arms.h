// URDFs of three styles, as rows of numbers from which the tests make both the text and KDL's chain.
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "tests/support/kdl_chain.h"

namespace sagitta::test {

constexpr double kHalfPi = 0.5 * kPi;

// Links l0, l1, …; comments, an inertia, a visual and a transmission that no edit may touch.
inline std::string UrdfText(const std::vector<UrdfRow>& rows, const std::string& name = "arm") {
  std::ostringstream text;
  text.precision(17);
  text << "<?xml version=\"1.0\" ?>\n<!-- made by hand; keep me -->\n<robot name=\"" << name
       << "\">\n  <link name=\"l0\">\n    <visual><origin xyz=\"0 0 1\" rpy=\"0 0 0\"/><geometry><box size=\"1 1 1\"/>"
       << "</geometry></visual>\n  </link>\n";
  for (size_t i = 0; i < rows.size(); ++i) {
    const UrdfRow& row = rows[i];
    text << "  <link name=\"l" << i + 1 << "\"/>\n  <joint name=\"" << row.name << "\" type=\"" << row.type
         << "\">\n    <!-- joint " << i << " -->\n    <parent link=\"l" << i << "\"/>\n    <child link=\"l" << i + 1
         << "\"/>\n";
    if (row.x != 0 || row.y != 0 || row.z != 0 || row.roll != 0 || row.pitch != 0 || row.yaw != 0) {
      text << "    <origin xyz=\"" << row.x << " " << row.y << " " << row.z << "\" rpy=\"" << row.roll << " "
           << row.pitch << " " << row.yaw << "\" />\n";
    }
    if (row.type != "fixed") {
      text << "    <axis xyz=\"" << row.ax << " " << row.ay << " " << row.az << "\"/>\n"
           << "    <limit lower=\"-3\" upper=\"3\" effort=\"10\" velocity=\"1\"/>\n";
    }
    text << "  </joint>\n";
  }
  text << "  <transmission name=\"t\"><type>x</type><joint name=\"" << rows[0].name
       << "\"><origin xyz=\"9 9 9\"/></joint></transmission>\n</robot>\n";
  return text.str();
}

// Universal Robots' older description: pitches of 90 degrees, axes y and z.
inline std::vector<UrdfRow> UniversalStyle() {
  return {{"pan", "revolute", 0, 0, 0.1273, 0, 0, 0, 0, 0, 1},
          {"lift", "revolute", 0, 0.220941, 0, 0, kHalfPi, 0, 0, 1, 0},
          {"elbow", "revolute", 0, -0.1719, 0.612, 0, 0, 0, 0, 1, 0},
          {"w1", "revolute", 0, 0, 0.5723, 0, kHalfPi, 0, 0, 1, 0},
          {"w2", "revolute", 0, 0.1149, 0, 0, 0, 0, 0, 0, 1},
          {"w3", "revolute", 0, 0, 0.1157, 0, 0, 0, 0, 1, 0},
          {"ee", "fixed", 0, 0.0922, 0, 0, 0, kHalfPi}};
}

// ROS-Industrial: rpy all zero, negative axes, flange and tool0 behind fixed joints.
inline std::vector<UrdfRow> IndustrialStyle() {
  return {{"foot", "fixed", 0, 0, 0.1, 0, 0, 0},
          {"a1", "revolute", 0, 0, 0.575, 0, 0, 0, 0, 0, -1},
          {"a2", "revolute", 0.35, 0, 0.1, 0, 0, 0, 0, 1, 0},
          {"a3", "revolute", 1.15, 0, 0, 0, 0, 0, 0, 1, 0},
          {"a4", "revolute", 0, 0, -0.041, 0, 0, 0, -1, 0, 0},
          {"a5", "revolute", 1.2, 0, 0, 0, 0, 0, 0, 1, 0},
          {"a6", "revolute", 0.215, 0, 0, 0, 0, 0, -1, 0, 0},
          {"flange", "fixed", 0, 0, 0, 0, 0, 0},
          {"tool0", "fixed", 0, 0, 0, 0, kHalfPi, 0}};
}

// An arm on a track: slide, oblique axes, any rpy, a fixed joint in the middle, seven revolute joints.
inline std::vector<UrdfRow> ObliqueStyle() {
  return {{"track", "prismatic", 0.2, -0.1, 0.3, 0.1, -0.2, 0.7, 0, 1, 0},
          {"j1", "revolute", 0.1, 0.02, 0.4, 0.3, 0.4, -0.5, 0.6, 0, 0.8},
          {"bracket", "fixed", 0.05, 0, 0.07, 0, 0.3, 2.0},
          {"j2", "continuous", 0.4, 0, 0.1, kHalfPi, -kHalfPi, 0, 0, 0, 1},
          {"j3", "revolute", -0.3, 0.2, 0.1, -2.0, kHalfPi, 1.0, 1, 0, 0},
          {"j4", "revolute", 0, 0, 0.5, 3.0, -1.0, 1.0, -0.48, 0.6, 0.64},
          {"slide", "prismatic", 0.1, 0.1, 0, 0, 0, 0, 0.6, 0.8, 0},
          {"j5", "revolute", 0, 0, 0.1, 0, 0, 0, 0, -1, 0},
          {"j6", "revolute", 0.02, 0, 0.3, 0, 0, 0, 0, 0, 1}};
}

}  // namespace sagitta::test
