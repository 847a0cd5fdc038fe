// What the shots of one structure have in common, so that several of them can be evaluated side by side.
//
// Shots have the same structure where they differ in numbers only: the same markers on the same frames, wrenches on
// the same frames, terms on the same transforms and parameters. The numbers of kBatchLanes shots lie lane by lane in
// one block (`data`); the program says which number lies where. What is the same in all lanes (values of the
// parameters, base pose, marker points) comes with the call.
//
// A unit twist of a transform is xi = (z, o x z) for a rotation and (0, z) for a translation, in the base frame: a
// point p moves by v + w x p, and a wrench (M0, F) about the base origin does the work w . M0 + v . F.
#pragma once

#include <cstdint>
#include <vector>

#include "models/forward_model.h"

namespace sagitta {

constexpr int kBatchLanes = 8;

struct ShotProgram {
  struct Scaled {  // parameter times a number of each lane
    int parameter = -1;
    int data = -1;
  };
  struct Transform {
    bool is_rotation = false;
    int axis = 0;
    double nominal = 0.0;
    int geometry = -1;          // parameter that adds to its value
    int lane_value = -1;        // data: sin and cos (rotation) or value of nominal + sign q; -1: no joint
    std::vector<Scaled> terms;  // effects that add to its value
    int slot = -1;              // elastic slot
    int twist = -1;             // index of its twist, where somebody differentiates by its value
    int kept_frame = -1;        // index of the frame right after it, where a marker or a wrench rides on that

    bool is_fixed() const { return lane_value < 0 && slot < 0 && terms.empty(); }  // the same in all lanes
  };
  struct Wrench {
    int kept_frame = 0;
    int level = 0;  // index of its frame among the distinct frames that bear wrenches, ascending
    bool in_base = false;
    int data = 0;  // point, force, moment: 9 numbers
  };
  struct Loads {
    int parameter = -1;  // -1: times one
    int slot = -1;       // of a sag: where it deflects
    std::vector<Wrench> wrenches;
  };
  struct Elastic {
    int slot = -1;
    int parameter = -1;
    int data = -1;
    ElasticLaw law = ElasticLaw::kLinear;
    double width = 0.0, centre = 0.0;  // of a smooth sign and of a bump
  };
  struct Slot {
    int transform = -1;
    int twist = -1;
    int level = 0;  // wrenches of this level and beyond act on it
  };
  struct Twist {
    int transform = -1;
    int level = 0;
    int slots = 0;  // that lie before its transform, or are it
    bool is_rotation = false;
  };
  struct MarkerDirection {
    int parameter = -1;
    int data = -1;  // 3 numbers
  };
  struct Station {
    int parameter = -1;
    int data = -1;  // gradient, row by row, then offset: 12 numbers
  };
  struct Sight {     // an error of a reading
    SightTerm term;  // what all lanes share: parameter, what is read wrong, and the law
    int data = -1;   // factor, instrument, axis, centre and width: 9 numbers

    // Of one lane; its numbers are kBatchLanes apart.
    SightTerm In(const double* lane) const {
      const auto at = [&](int i) { return lane[(data + i) * kBatchLanes]; };
      SightTerm own = term;
      own.factor = at(0);
      own.instrument = {at(1), at(2), at(3)};
      own.axis = {at(4), at(5), at(6)};
      own.centre = at(7);
      own.width = at(8);
      return own;
    }
  };
  struct Marker {
    int id = -1;
    int kept_frame = 0;
    bool grows = false;
    bool sees_equally = false;  // its whitener is a number times the identity, in all lanes
    int whitener = 0;           // data: that number, or 9, row by row
    int point = 0;              // data: measured
    std::vector<MarkerDirection> terms;
    std::vector<Sight> sights;
  };
  struct FrameClass {  // a frame that bears markers
    int frame = 0;
    std::vector<int> markers;
  };
  struct Spring {
    int slot = -1;
    int transform = -1;
    int first_parameter = 0;
    double sin_offset = 0.0, cos_offset = 1.0, sign = 1.0;
    int commanded = -1;  // data: sin and cos of the commanded joint value, where only the change acts
  };

  // What adds to the column of a parameter.
  enum class PartOf { kTransform, kElastic, kLoads, kSag, kSpring };
  struct Part {
    PartOf of = PartOf::kTransform;
    int index = 0;  // of the twist, or in the list of that name; of the spring's parameter
    int data = -1;  // a twist's factor; -1: one
  };

  std::vector<Transform> transforms;
  int world_frame = -1;  // kept frame of the chain's first frame
  int num_kept_frames = 0;
  std::vector<Twist> twists;
  std::vector<Slot> slots;
  std::vector<Elastic> elastic;
  std::vector<Loads> loads, sags;
  int num_levels = 0;
  bool has_base_loads = false;
  std::vector<Marker> markers;
  std::vector<FrameClass> classes;
  std::vector<Scaled> growth;
  std::vector<Station> station;
  std::vector<int> joint_twists;  // of each joint
  std::vector<double> joint_signs;
  bool has_spring = false;
  Spring spring;
  std::vector<int> slot_data;  // of the effects that add to values of transforms, in the shot's order
  int num_parameters = 0;
  std::vector<Part> parts;      // parameter by parameter
  std::vector<int> first_part;  // of each parameter, and the end
  int num_data = 0;             // numbers of each lane

  bool is_elastic() const { return !slots.empty(); }
  // Whether parameters move what is seen of it where it is, and not by the arm alone.
  bool MovesDirectly(const Marker& marker) const {
    return !(marker.terms.empty() && marker.sights.empty() && growth.empty() && station.empty());
  }
};

// A marker of a shot as it was read.
struct BatchReading {
  int id = -1;
  int frame = 0;
  Vector3<double> point_in_station;
  Matrix3<double> whitener;
};

// Equal keys: the same structure. Empty: a shot that only the model itself evaluates (wrenches that turn with the
// flange, measured torques).
std::vector<std::int64_t> StructureOf(const ForwardModel& model, const ShotInput& shot,
                                      const std::vector<BatchReading>& readings);
// The same behind what `key` holds; false, and nothing is added: only the model itself evaluates the shot.
bool AppendStructure(const ForwardModel& model, const ShotInput& shot, const std::vector<BatchReading>& readings,
                     std::vector<std::int64_t>* key);

// `shot` stands for all of its structure.
ShotProgram MakeShotProgram(const ForwardModel& model, const ShotInput& shot,
                            const std::vector<BatchReading>& readings);

// The whitener of one of its markers in a lane of such a block.
Matrix3<double> PackedWhitener(const ShotProgram::Marker& marker, int lane, const double* data);

// Writes the numbers of one shot into its lane of a block of num_data * kBatchLanes doubles.
void PackShot(const ForwardModel& model, const ShotProgram& program, const ShotInput& shot,
              const std::vector<BatchReading>& readings, int lane, double* data);

}  // namespace sagitta
