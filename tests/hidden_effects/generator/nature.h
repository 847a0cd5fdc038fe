// Everything that really happens between a command and a reading, cause by
// cause. The believed model knows a part of it.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/hidden_effects/generator/arm.h"
#include "tests/hidden_effects/generator/instrument.h"

namespace hidden {

constexpr double kGravity = 9.80665;  // m/s^2
constexpr double kMicro = 1e-6;

// One shot of the instrument, as commanded and stated.
struct Shot {
  int config = 0;
  std::string station = "S1";
  std::string load = "none";
  VectorXd q;                                 // commanded, rad or m
  Vector3d force = Vector3d::Zero();          // N, stated, measurement frame
  double time = 0.0;                          // s
  double since_start = 0.0;                   // s since the station's first row
  double since_first = 0.0;                   // s since the first row of all
  double air = 20.0, arm_temperature = 20.0;  // degC
  std::vector<int> approach;                  // direction of each joint's last motion
  Vector3d sigma = Vector3d::Zero();          // m, stated
};

struct StationPose {
  Vector3d origin = Vector3d::Zero();
  Matrix3d turn = Matrix3d::Identity();
};

struct Weight {
  int link = 0;  // the link after this joint
  double mass = 0.0;
  Vector3d centre = Vector3d::Zero();  // in the frame after the joint
};

// A real spring between a point of the link and a point of the frame before it.
struct Spring {
  int joint = 1;
  double L = 0, a_x = 0, a_y = 0, s0 = 0, Kc = 0;  // m, N/m
};

struct Drift {
  Vector3d move = Vector3d::Zero();  // m/s
  Vector3d turn = Vector3d::Zero();  // rad/s
};

struct Nature {
  Arm arm;
  std::map<std::string, StationPose> stations;
  std::map<std::string, Vector3d> markers;  // flange frame, m
  Vector3d load_point = Vector3d::Zero();   // flange frame, m

  // Encoder side: deviation of a joint, rad.
  struct Encoder {
    int joint;
    std::function<double(const Shot&)> deviation;
  };
  std::vector<Encoder> encoder;
  std::vector<VectorXd> latent;  // per configuration
  // Half a gap, rad, that the torque closes: over this many N m by e-folds, at once for 0.
  struct TorquePlay {
    double half_gap = 0.0, width = 0.0;
  };
  std::map<int, TorquePlay> torque_play;
  // Gear side: deviation of a joint, rad, from its torque, N m.
  struct Gear {
    int joint;
    std::function<double(const Shot&, double torque)> deviation;
  };
  std::vector<Gear> gears;

  // Elastic: rad/(N m), rad/(kN m)^3.
  VectorXd compliance, hardening;
  std::vector<Vector3d> tilt_compliance;  // about x, y, z of the frame after the joint
  Vector3d foot_compliance = Vector3d::Zero();

  // Running error of an axis: tilt about x, y, z of the frame after the joint.
  struct Wobble {
    int joint, about;
    std::function<double(const Shot&)> tilt;
  };
  std::vector<Wobble> wobble;

  // The link after this joint bends about its middle under the moment there of what hangs beyond it, a weight of its
  // own among that; rad/(N m), frame after the joint.
  struct Bending {
    int link;
    Weight beyond;
    Matrix3d flexibility;
  };
  std::vector<Bending> bendings;
  // A bearing that lets its joint's axis tilt (as tilt_compliance) by the moment across the axis there, of what hangs
  // beyond it, a weight of its own among that; N m, frame after the joint.
  struct Bearing {
    int joint;
    Weight beyond;
    std::function<Vector3d(const Vector3d& across)> tilt;
  };
  std::vector<Bearing> bearings;
  std::function<Vector3d(const Shot&, int link)> warp;       // bend without a moment, as bendings: rad; may be empty
  std::function<double(const Shot&, int link)> lengthening;  // part of its length; may be empty
  std::function<Vector3d(const Shot&)> floor;                // tilt of the foot, rad; may be empty

  std::vector<Weight> weights;
  std::optional<Spring> spring;
  std::map<std::string, double> extra_mass;          // by load, kg
  std::map<std::string, Vector3d> centre_off_point;  // by load, m, flange frame
  // Of the load's centre, by where down is (of length 1); m, flange frame; may be empty.
  std::function<Vector3d(const Shot&, const Vector3d& down)> load_shift;

  double growth = 0.0;                 // 1/K
  double reference_temperature = 0.0;  // degC
  std::map<std::string, Drift> drift;
  std::map<std::string, double> scale;
  std::map<std::string, Settling> settling;
  std::map<std::string, Instrument> instruments;
  std::map<std::string, Reflector> reflectors;
  struct Reseat {
    std::string marker;
    double after = 0.0;  // s since the first row of all
    Vector3d shift = Vector3d::Zero();
  };
  std::vector<Reseat> reseats;
  // Where a marker sits on the flange: shift, m, flange frame.
  std::vector<std::function<Vector3d(const Shot&, const std::string& marker)>> seats;
  std::function<Vector3d(const Shot&)> shake;  // of the station, m; may be empty
  // Of the single reading at a point: m, station frame; may be empty.
  std::function<Vector3d(const Shot&, const std::string& marker, const Vector3d& point)> disturbance;
};

// Where a marker is really seen, without the instrument's noise; m, station frame.
Vector3d SeenAt(const Nature& nature, const Shot& shot, const std::string& marker);

// The posture in equilibrium: deflections from torques at the deflected posture,
// iterated until they stand.
Posture Equilibrium(const Nature& nature, const Shot& shot);

}  // namespace hidden
