#include "estimator/inspection/readings.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/report/inspection_reading_words.h"
#include "models/constants.h"
#include "problems/choices.h"

namespace sagitta {
namespace {

using Readings = std::vector<Reading>;

struct Change {
  std::function<void(Measurements*)> rows;
  bool is_of_joints = false;
};

// The same change to the joint values of every configuration.
Change OfJoints(std::function<void(Eigen::VectorXd*)> change) {
  const auto rows = [change = std::move(change)](Measurements* data) {
    for (Configuration& configuration : data->configurations) change(&configuration.q);
  };
  return {rows, true};
}

Change OfPoints(std::function<void(Vector3<double>*)> change) {
  const auto rows = [change = std::move(change)](Measurements* data) {
    for (Observation& observation : data->observations) change(&observation.point_in_station);
  };
  return {rows, false};
}

bool IsRevolute(const Chain& chain, int joint) { return chain.joints[joint].type == JointType::kRevolute; }

std::vector<std::string> NamesOf(const Chain& chain, const std::vector<int>& joints) {
  std::vector<std::string> names;
  for (const int j : joints) names.push_back(chain.joints[j].name);
  return names;
}

void Add(const char* code, const Advice& advice, Change change, Readings* readings) {
  readings->push_back({code, advice.words, advice.remedy, std::move(change.rows), change.is_of_joints, {}});
}

void Add(const char* code, const Advice& advice, const Robot& robot, Readings* readings) {
  readings->push_back({code, advice.words, advice.remedy, {}, false, robot});
}

// Sets of `size` joints that are counted the other way.
void AddFlips(const Chain& chain, int size, Readings* readings) {
  std::vector<bool> chosen(chain.num_joints(), false);
  if (size > chain.num_joints()) return;
  std::fill(chosen.begin(), chosen.begin() + size, true);
  do {
    std::vector<int> joints;
    for (int j = 0; j < chain.num_joints(); ++j) {
      if (chosen[j]) joints.push_back(j);
    }
    const auto flip = [joints](Eigen::VectorXd* q) {
      for (const int j : joints) (*q)[j] *= -1.0;
    };
    Add("sign_flip", JointsFlipped(NamesOf(chain, joints)), OfJoints(flip), readings);
  } while (std::prev_permutation(chosen.begin(), chosen.end()));
}

void AddOffsets(const Chain& chain, Readings* readings) {
  for (int j = 0; j < chain.num_joints(); ++j) {
    if (!IsRevolute(chain, j)) continue;
    for (const int quarter : {1, -1, 2}) {
      for (const double sign : {1.0, -1.0}) {
        const auto turn = [j, sign, quarter](Eigen::VectorXd* q) { (*q)[j] = sign * (*q)[j] + quarter * 0.5 * kPi; };
        Add("joint_offset", ZeroTurned(chain.joints[j].name, quarter, sign < 0.0), OfJoints(turn), readings);
      }
    }
  }
}

// Of a table whose rows have alpha and a of the other convention: the row that row i of n has them from.
int RowOffBy(DhConvention convention, int i, int n) {
  switch (convention) {
    case DhConvention::kStandard:
      return (i + 1) % n;
    case DhConvention::kModified:
      return (i + n - 1) % n;
  }
  return i;
}

void AddTables(const CalibrationProblem& problem, Readings* readings) {
  if (!problem.robot().dh) return;
  const auto add = [&](const Advice& advice, const DhTable& table) {
    Robot robot = problem.robot();
    robot.chain = ChainFromDhTable(robot.chain.joints, robot.chain.couplings, table);
    robot.dh = table;
    Add("dh_convention", advice, robot, readings);
  };
  const DhConvention own = problem.robot().dh->convention;
  for (const DhConvention convention : ChoicesOf<DhConvention>()) {
    if (convention == own) continue;
    DhTable other = *problem.robot().dh;
    other.convention = convention;
    add(TableIn(convention), other);
  }
  // alpha and a of the link before: a modified table typed into rows of a standard one, and the reverse
  DhTable shifted = *problem.robot().dh;
  const int n = static_cast<int>(shifted.links.size());
  for (int i = 0; i < n; ++i) {
    const int from = RowOffBy(own, i, n);
    shifted.links[i].a = problem.robot().dh->links[from].a;
    shifted.links[i].alpha = problem.robot().dh->links[from].alpha;
  }
  add(TableOneRowOff(), shifted);
  DhTable without_beta = *problem.robot().dh;
  bool any_beta = false;
  for (DhLink& link : without_beta.links) {
    any_beta |= link.beta != 0.0;
    link.beta = -link.beta;
  }
  if (any_beta) add(BetaTurned(), without_beta);
  for (int i = 0; i < n; ++i) {
    if (std::abs(std::sin(problem.robot().dh->links[i].alpha)) < 0.5) continue;  // 0 and 180 deg have no other sign
    DhTable turned = *problem.robot().dh;
    turned.links[i].alpha *= -1.0;
    add(AlphaTurned(problem.robot().chain.joints[turned.links[i].joint].name), turned);
  }
}

// Position i of the columns holds the value of joint order[i].
void AddOrder(const Chain& chain, const std::vector<int>& order, const Advice& advice, Readings* readings) {
  for (size_t i = 0; i < order.size(); ++i) {
    if (chain.joints[i].type != chain.joints[order[i]].type) return;  // columns have the unit of their joint
  }
  const auto reorder = [order](Eigen::VectorXd* q) {
    const Eigen::VectorXd stated = *q;
    for (size_t i = 0; i < order.size(); ++i) (*q)[order[i]] = stated[static_cast<int>(i)];
  };
  Add("joint_order", advice, OfJoints(reorder), readings);
}

void AddOrders(const Chain& chain, Readings* readings) {
  const int n = chain.num_joints();
  std::vector<int> straight(n);
  for (int i = 0; i < n; ++i) straight[i] = i;
  const auto name_of = [&](int j) { return chain.joints[j].name; };
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      std::vector<int> order = straight;
      std::swap(order[a], order[b]);
      AddOrder(chain, order, ColumnsExchanged(name_of(a), name_of(b)), readings);
    }
  }
  std::vector<int> reversed(straight.rbegin(), straight.rend());
  if (n > 2) AddOrder(chain, reversed, ColumnsReversed(), readings);
  for (int a = 0; a < n; ++a) {
    for (int b = a + 1; b < n; ++b) {
      for (int c = b + 1; c < n; ++c) {
        for (const bool forward : {true, false}) {
          std::vector<int> order = straight;
          order[a] = forward ? b : c;
          order[b] = forward ? c : a;
          order[c] = forward ? a : b;
          AddOrder(chain, order, ColumnsInCyclicOrder(NamesOf(chain, {a, b, c})), readings);
        }
      }
    }
  }
  for (int shift = 1; n > 3 && shift < n; ++shift) {
    std::vector<int> order = straight;
    std::rotate(order.begin(), order.begin() + shift, order.end());
    AddOrder(chain, order, ColumnsBeginWith(name_of(order[0])), readings);
  }
}

// Controllers count a joint from the link before or from the horizontal: then the driver's value is in it.
void AddCouplings(const Chain& chain, Readings* readings) {
  if (!chain.couplings.empty()) return;
  for (int j = 1; j < chain.num_joints(); ++j) {
    if (!IsRevolute(chain, j) || !IsRevolute(chain, j - 1)) continue;
    for (const int ratio : {1, -1}) {
      const auto couple = [j, ratio](Eigen::VectorXd* q) { (*q)[j] += ratio * (*q)[j - 1]; };
      Add("coupling", JointCoupled(chain.joints[j].name, chain.joints[j - 1].name, ratio), OfJoints(couple), readings);
    }
  }
}

void AddFrames(Readings* readings) {
  Add("mirrored", FrameMirrored(), OfPoints([](Vector3<double>* point) { point->z() *= -1.0; }), readings);
}

// Joint values in m below a header that says mm, and the other way round.
void AddLinearUnits(const Chain& chain, Readings* readings) {
  std::vector<int> linear;
  for (int j = 0; j < chain.num_joints(); ++j) {
    if (!IsRevolute(chain, j)) linear.push_back(j);
  }
  for (const bool metres : {true, false}) {
    if (linear.empty()) return;
    const auto scale = [linear, factor = metres ? 1e3 : 1e-3](Eigen::VectorXd* q) {
      for (const int j : linear) (*q)[j] *= factor;
    };
    Add("unit", LinearJointsIn(metres, linear), OfJoints(scale), readings);
  }
}

Reading RobotIn(const CalibrationProblem& problem, Motion motion, double factor, RobotNumbers unit) {
  Robot scaled = problem.robot();
  scaled.dh.reset();  // its chain alone is read in another unit
  for (ElementaryTransform& transform : scaled.chain.transforms) {
    if (transform.motion == motion) transform.nominal *= factor;
  }
  Readings reading;
  Add("unit", RobotReadIn(unit), scaled, &reading);
  return reading.front();
}

void AddUnits(const CalibrationProblem& problem, Readings* readings) {
  readings->push_back(RobotIn(problem, Motion::kTranslation, 1e3, RobotNumbers::kMetres));
  readings->push_back(RobotInMillimetres(problem));
  readings->push_back(RobotIn(problem, Motion::kTranslation, 25.4, RobotNumbers::kInches));
  readings->push_back(RobotIn(problem, Motion::kRotation, 1.0 / kDegree, RobotNumbers::kRadians));
  Add("unit", PointsInInches(), OfPoints([](Vector3<double>* point) { *point *= 25.4; }), readings);
  for (int j = 0; j < problem.robot().chain.num_joints(); ++j) {
    if (!IsRevolute(problem.robot().chain, j)) continue;
    const auto to_degrees = [j](Eigen::VectorXd* q) { (*q)[j] *= 1.0 / kDegree; };
    Add("unit", JointInRadians(problem.robot().chain.joints[j].name), OfJoints(to_degrees), readings);
  }
  AddLinearUnits(problem.robot().chain, readings);
}

// Joint values of the configuration `shift` places on; those at the ends have none.
std::map<std::string, Eigen::VectorXd> NeighboursById(const Measurements& data, int shift) {
  std::map<std::string, Eigen::VectorXd> neighbours;
  const int n = static_cast<int>(data.configurations.size());
  for (int c = 0; c < n; ++c) {
    if (c + shift >= 0 && c + shift < n) neighbours[data.configurations[c].id] = data.configurations[c + shift].q;
  }
  return neighbours;
}

// Points of one configuration written next to the joint values of its neighbour.
void AddRowShifts(const CalibrationProblem& problem, Readings* readings) {
  for (const int shift : {1, -1}) {
    const auto move = [neighbours = NeighboursById(problem.data(), shift)](Measurements* data) {
      std::vector<bool> lost;
      for (Configuration& configuration : data->configurations) {
        const auto neighbour = neighbours.find(configuration.id);
        lost.push_back(neighbour == neighbours.end());
        if (!lost.back()) configuration.q = neighbour->second;
      }
      for (Observation& row : data->observations) row.excluded |= lost[data->shots[row.shot].configuration];
    };
    Add("row_shift", RowsShifted(shift > 0), Change{move, true}, readings);
    readings->back().is_of_order = true;
  }
}

}  // namespace

std::vector<Reading> AllReadings(const CalibrationProblem& problem) {
  const Chain& chain = problem.robot().chain;
  Readings readings;
  AddTables(problem, &readings);
  AddFlips(chain, 1, &readings);
  AddOffsets(chain, &readings);
  AddUnits(problem, &readings);
  AddFlips(chain, 2, &readings);
  AddCouplings(chain, &readings);
  AddOrders(chain, &readings);
  AddFrames(&readings);  // of an arm that is its own mirror image: the same as flips of three joints
  AddFlips(chain, 3, &readings);
  AddRowShifts(problem, &readings);
  return readings;
}

Reading RobotInMillimetres(const CalibrationProblem& problem) {
  return RobotIn(problem, Motion::kTranslation, 1e-3, RobotNumbers::kMillimetres);
}

CalibrationProblem Reread(const CalibrationProblem& problem, const Reading& reading) {
  if (reading.robot) {
    Experiment experiment = problem.experiment();
    experiment.validation = ValidationSpec();
    experiment.validation.kind = ValidationSpec::Kind::kNone;
    return MakeCalibrationProblem(*reading.robot, problem.data(), experiment);
  }
  CalibrationProblem reread = problem;
  reading.change(reread.mutable_data());
  reread.RenewJoints();
  return reread;
}

}  // namespace sagitta
