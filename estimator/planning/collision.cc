#include "estimator/planning/collision.h"

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <cstdlib>

namespace sagitta {

// A convex body and the sphere around it, by which most pairs are separated.
struct CollisionBody {
  std::string name;
  std::shared_ptr<fcl::CollisionGeometryd> shape;
  fcl::Transform3d place = fcl::Transform3d::Identity();  // base_from_shape
  double reach = 0.0;                                     // m, of the sphere around its centre
};

namespace {

bool Meet(const CollisionBody& a, const CollisionBody& b) {
  if ((a.place.translation() - b.place.translation()).norm() > a.reach + b.reach) return false;
  const fcl::CollisionRequestd request(1, false);
  fcl::CollisionResultd result;
  return fcl::collide(a.shape.get(), a.place, b.shape.get(), b.place, request, result) > 0;
}

// FCL's capsule lies along its own z, its centre at the origin.
CollisionBody CapsuleBetween(const std::string& name, const Vector3<double>& from, const Vector3<double>& to,
                             double radius) {
  const double length = (to - from).norm();
  CollisionBody body{name, std::make_shared<fcl::Capsuled>(radius, length), fcl::Transform3d::Identity(),
                     0.5 * length + radius};
  const Vector3<double> along = length > 0.0 ? Vector3<double>((to - from) / length) : Vector3<double>::UnitZ();
  body.place.linear() = RotationBetween(Vector3<double>::UnitZ(), along);
  body.place.translation() = 0.5 * (from + to);
  return body;
}

CollisionBody BoxOf(const CellBox& box) {
  CollisionBody body{box.name, std::make_shared<fcl::Boxd>(2.0 * box.half_size), fcl::Transform3d::Identity(),
                     box.half_size.norm()};
  body.place.linear() = box.base_from_box.rotation;
  body.place.translation() = box.base_from_box.translation;
  return body;
}

}  // namespace

struct CollisionScene::Shapes {
  struct Link {
    CollisionBody body;
    fcl::Transform3d in_frame;  // frame_from_shape
    int frame = 0;              // of the chain
    int moved_by = 0;           // joints before it
    double half_length = 0.0, radius = 0.0;
  };
  std::vector<Link> links;
  std::vector<CollisionBody> boxes;
  std::vector<std::pair<int, int>> pairs;  // links that must not touch
  std::optional<double> floor;
  double clearance = 0.0, beam_radius = 0.0, beam_end = 0.0;

  // With the clearance added to the first of two bodies.
  CollisionBody Placed(int link, const std::vector<Pose<double>>& frames, bool widened) const {
    const Link& own = links[link];
    CollisionBody body = own.body;
    fcl::Transform3d frame = fcl::Transform3d::Identity();
    frame.linear() = frames[own.frame].rotation;
    frame.translation() = frames[own.frame].translation;
    body.place = frame * own.in_frame;
    if (widened && clearance > 0.0) {
      body.shape = std::make_shared<fcl::Capsuled>(own.radius + clearance, 2.0 * own.half_length);
      body.reach += clearance;
    }
    return body;
  }
};

CollisionScene::CollisionScene(const Chain& chain, const Cell& cell) : shapes_(std::make_unique<Shapes>()) {
  for (const LinkCapsule& capsule : cell.capsules) {
    Shapes::Link link;
    link.body = CapsuleBetween(capsule.name, capsule.from, capsule.to, capsule.radius);
    link.in_frame = link.body.place;
    const bool on_flange = capsule.on == LinkCapsule::kFlange, on_base = capsule.on == LinkCapsule::kBase;
    link.frame = on_flange ? chain.FlangeFrame() : on_base ? chain.BaseFrame() : chain.FrameAfterJoint(capsule.on);
    link.moved_by = on_flange ? chain.num_joints() : on_base ? 0 : capsule.on + 1;
    link.half_length = 0.5 * (capsule.to - capsule.from).norm();
    link.radius = capsule.radius;
    shapes_->links.push_back(link);
  }
  const auto may_touch = [&](int a, int b) {
    return std::any_of(cell.may_touch.begin(), cell.may_touch.end(), [&](const std::array<int, 2>& pair) {
      return (pair[0] == a && pair[1] == b) || (pair[0] == b && pair[1] == a);
    });
  };
  for (int a = 0; a < static_cast<int>(shapes_->links.size()); ++a) {
    for (int b = 0; b < a; ++b) {
      const bool share_a_joint = std::abs(shapes_->links[a].moved_by - shapes_->links[b].moved_by) <= 1;
      if (!share_a_joint && !may_touch(a, b)) shapes_->pairs.emplace_back(b, a);
    }
  }
  for (const CellBox& box : cell.keep_out) shapes_->boxes.push_back(BoxOf(box));
  shapes_->floor = cell.floor;
  shapes_->clearance = cell.clearance;
  shapes_->beam_radius = cell.beam_radius;
  shapes_->beam_end = cell.beam_end;
}

CollisionScene::~CollisionScene() = default;

std::string CollisionScene::Collision(const std::vector<Pose<double>>& frames) const {
  const int count = static_cast<int>(shapes_->links.size());
  std::vector<CollisionBody> bodies, widened;
  for (int i = 0; i < count; ++i) {
    bodies.push_back(shapes_->Placed(i, frames, false));
    widened.push_back(shapes_->Placed(i, frames, true));
  }
  for (int i = 0; i < count; ++i) {
    const Shapes::Link& link = shapes_->links[i];
    if (link.moved_by == 0) continue;
    const double rises = link.half_length * std::abs(bodies[i].place.linear()(2, 2));
    const double lowest = bodies[i].place.translation().z() - rises - link.radius - shapes_->clearance;
    if (shapes_->floor && lowest < *shapes_->floor) return link.body.name + " reaches the floor";
    for (const CollisionBody& box : shapes_->boxes) {
      if (Meet(widened[i], box)) return link.body.name + " meets " + box.name;
    }
  }
  for (const auto& [a, b] : shapes_->pairs) {
    if (Meet(widened[a], bodies[b])) return bodies[a].name + " meets " + bodies[b].name;
  }
  return "";
}

std::string CollisionScene::Obstruction(const std::vector<Pose<double>>& frames, const Vector3<double>& instrument,
                                        const Vector3<double>& reflector) const {
  const double length = (reflector - instrument).norm();
  if (length <= shapes_->beam_end) return "";
  const Vector3<double> end = instrument + (1.0 - shapes_->beam_end / length) * (reflector - instrument);
  const CollisionBody beam = CapsuleBetween("beam", instrument, end, std::max(shapes_->beam_radius, 1e-4));
  for (int i = 0; i < static_cast<int>(shapes_->links.size()); ++i) {
    if (Meet(beam, shapes_->Placed(i, frames, false))) return shapes_->links[i].body.name;
  }
  for (const CollisionBody& box : shapes_->boxes) {
    if (Meet(beam, box)) return box.name;
  }
  return "";
}

}  // namespace sagitta
