// Tables of readings that can be spoiled, and what `sagitta import` has to make of them: one simulated UR5, its points
// from KDL.
#pragma once

#ifdef SAGITTA_HAVE_KDL

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

#include "tests/support/kdl_chain.h"
#include "tests/support/paths.h"
#include "tests/tools/program.h"

namespace sagitta::test {

struct Reading {
  std::vector<double> q_deg;
  std::vector<double> xyz_mm;
};

// Points that a robot with small errors shows, from KDL; `nominal`: without errors. `marker`: in the flange, m.
inline std::vector<Reading> MakeReadings(bool nominal, const KDL::Vector& marker = KDL::Vector(0.02, 0.05, 0.08)) {
  std::vector<DhRow> rows = Ur5Rows();
  RandomNumbers random(17);
  for (DhRow& row : rows) {
    if (nominal) break;
    row.a += random.Uniform(-1e-3, 1e-3);
    row.d += random.Uniform(-1e-3, 1e-3);
    row.alpha_deg += random.Uniform(-0.1, 0.1);
    row.theta_deg += random.Uniform(-0.1, 0.1);
  }
  const KDL::Chain chain = KdlChainOfDh(DhConvention::kStandard, rows);
  const KDL::Frame base(KDL::Rotation::RPY(0.1, -0.2, 1.0), KDL::Vector(2.1, -1.3, 0.4));
  std::vector<Reading> readings;
  RandomNumbers poses(18);
  for (int k = 0; k < 30; ++k) {
    Reading reading;
    Eigen::VectorXd q(6);
    for (int j = 0; j < 6; ++j) {
      reading.q_deg.push_back(std::round(poses.Uniform(-170, 170) * 1e3) / 1e3);
      q[j] = reading.q_deg[j] * kDegree;
    }
    const KDL::Vector p = base * KdlFlange(chain, q) * marker;
    for (int i = 0; i < 3; ++i) reading.xyz_mm.push_back(nominal ? 1e3 * p[i] : std::round(1e7 * p[i]) / 1e4);
    readings.push_back(reading);
  }
  return readings;
}

inline std::string Text(double value, int digits = 12) {
  std::ostringstream text;
  text.precision(digits);
  text << value;
  return text.str();
}

// A table that can be spoiled: cells first, then the way they are written.
struct Table {
  std::vector<std::string> header = {"q1_deg", "q2_deg", "q3_deg", "q4_deg", "q5_deg",
                                     "q6_deg", "x_mm",   "y_mm",   "z_mm"};
  std::vector<std::vector<std::string>> rows;
  std::string separator = ",";
  std::string line_end = "\n";
  std::string preamble;

  explicit Table(const std::vector<Reading>& readings, double angle = 1.0, double length = 1.0) {
    for (const Reading& reading : readings) {
      rows.emplace_back();
      for (const double q : reading.q_deg) rows.back().push_back(Text(q * angle, 17));
      for (const double x : reading.xyz_mm) rows.back().push_back(Text(x * length, 17));
    }
  }

  std::string Join(const std::vector<std::string>& cells) const {
    std::string line;
    for (size_t c = 0; c < cells.size(); ++c) line += (c > 0 ? separator : "") + cells[c];
    return line + line_end;
  }
  std::string ToText() const {
    std::string text = preamble;
    if (!header.empty()) text += Join(header);
    for (const auto& row : rows) text += Join(row);
    return text;
  }

  Table& DecimalComma() {
    for (auto& row : rows) {
      for (std::string& cell : row) std::replace(cell.begin(), cell.end(), '.', ',');
    }
    return *this;
  }
  Table& Quoted() {
    for (auto& row : rows) {
      for (std::string& cell : row) cell = "\"" + cell + "\"";
    }
    return *this;
  }
  Table& With(const std::string& a_separator) {
    separator = a_separator;
    return *this;
  }
  Table& Named(const std::vector<std::string>& names) {
    header = names;
    return *this;
  }
  // A column of equal or counted cells at a place.
  Table& Insert(size_t at, const std::string& name, const std::function<std::string(size_t)>& cell) {
    if (!header.empty()) header.insert(header.begin() + at, name);
    for (size_t r = 0; r < rows.size(); ++r) rows[r].insert(rows[r].begin() + at, cell(r));
    return *this;
  }
  Table& Reordered(const std::vector<int>& order) {
    const auto pick = [&order](const std::vector<std::string>& cells) {
      std::vector<std::string> picked;
      for (const int c : order) picked.push_back(cells[c]);
      return picked;
    };
    if (!header.empty()) header = pick(header);
    for (auto& row : rows) row = pick(row);
    return *this;
  }
};

inline std::string Utf16(const std::string& text, bool little, bool bom) {
  std::string bytes = bom ? (little ? "\xFF\xFE" : "\xFE\xFF") : "";
  for (const char c : text) {
    if (little) bytes += c;
    bytes += '\0';
    if (!little) bytes += c;
  }
  return bytes;
}

constexpr char kRobot[] = R"(schema: sagitta/robot/1
joints:
  - {name: j1, type: revolute}
  - {name: j2, type: revolute}
  - {name: j3, type: revolute}
  - {name: j4, type: revolute}
  - {name: j5, type: revolute}
  - {name: j6, type: revolute}
kinematics:
  dh:
    convention: standard
    links:
      - {joint: j1, a_mm: 0, alpha_deg: 90, d_mm: 89.159, theta_deg: 0}
      - {joint: j2, a_mm: -425, alpha_deg: 0, d_mm: 0, theta_deg: 0}
      - {joint: j3, a_mm: -392.25, alpha_deg: 0, d_mm: 0, theta_deg: 0}
      - {joint: j4, a_mm: 0, alpha_deg: 90, d_mm: 109.15, theta_deg: 0}
      - {joint: j5, a_mm: 0, alpha_deg: -90, d_mm: 94.65, theta_deg: 0}
      - {joint: j6, a_mm: 0, alpha_deg: 0, d_mm: 82.3, theta_deg: 0}
)";

class Import : public ProgramTest {
 protected:
  Outcome ImportText(const std::string& bytes, std::vector<std::string> flags = {}) const {
    std::vector<std::string> arguments = {"import", Write("robot.yaml", kRobot), Write("export.txt", bytes),
                                          "--out=" + Path("job")};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    std::filesystem::remove_all(Path("job"));
    return Run(arguments);
  }

  // What was written equals the readings, `lost` ones (by index) left out.
  void ExpectRight(const std::string& bytes, const std::vector<Reading>& readings,
                   const std::vector<std::string>& flags = {}, const std::vector<size_t>& lost = {}) const {
    const Outcome outcome = ImportText(bytes, flags);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    const auto cells = Cells(Read("job/measurements.csv"));
    ASSERT_EQ(cells.size(), 1 + readings.size() - lost.size()) << outcome.out;
    size_t row = 0;
    for (size_t r = 0; r < readings.size(); ++r) {
      if (std::count(lost.begin(), lost.end(), r)) continue;
      ++row;
      for (int j = 0; j < 6; ++j) Expect(cells, row, "q" + std::to_string(j + 1), readings[r].q_deg[j]);
      for (int i = 0; i < 3; ++i) Expect(cells, row, std::string(1, "xyz"[i]), readings[r].xyz_mm[i]);
    }
    const Outcome inspected = Run({"inspect", Path("job/experiment.yaml")});
    EXPECT_EQ(inspected.status, 0) << inspected.err;
  }

  void ExpectRefused(const std::string& bytes, const std::vector<std::string>& words,
                     const std::vector<std::string>& flags = {}) const {
    const Outcome outcome = ImportText(bytes, flags);
    EXPECT_EQ(outcome.status, 2) << outcome.out;
    for (const std::string& word : words)
      EXPECT_NE(outcome.err.find(word), std::string::npos) << "'" << word << "' is not in: " << outcome.err;
    EXPECT_FALSE(Exists("job")) << "nothing is written";
  }

 private:
  static void Expect(const std::vector<std::vector<std::string>>& cells, size_t row, const std::string& stem,
                     double expected) {
    const std::map<std::string, double> kFactors = {{"_deg", 1.0}, {"_rad", 1.0 / kDegree}, {"_mm", 1.0}, {"_m", 1e3}};
    for (size_t c = 0; c < cells[0].size(); ++c) {
      for (const auto& [suffix, factor] : kFactors) {
        if (cells[0][c] != stem + suffix) continue;
        EXPECT_NEAR(std::stod(cells[row][c]) * factor, expected, 1e-9 * std::max(1.0, std::abs(expected)))
            << stem << " row " << row;
        return;
      }
    }
    ADD_FAILURE() << "no column " << stem;
  }
};

inline const std::vector<Reading>& Readings() {
  static const std::vector<Reading> readings = MakeReadings(false);
  return readings;
}

inline std::function<std::string(size_t)> Counted(int from) {
  return [from](size_t r) { return std::to_string(r + from); };
}
inline std::function<std::string(size_t)> Always(const std::string& text) {
  return [text](size_t) { return text; };
}

}  // namespace sagitta::test

#endif
