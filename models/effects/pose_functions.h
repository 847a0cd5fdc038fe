// What a deviation without a name may follow of the arm's posture and its load: which way is down, where the flange is,
// how heavy the load is. Shared by the effects that are learnt and by the columns that find them.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "models/chain.h"
#include "models/wrench.h"

namespace sagitta {

// Of a unit vector: all products of up to `degree` of its components, with factors that make a random function (weights
// of unit variance) one of the angle between two directions: kernel (c + ... + c^degree) / degree, c its cosine.
Eigen::VectorXd DirectionFunctions(const Vector3<double>& direction, int degree);
int NumDirectionFunctions(int degree);
constexpr int kHighestDirectionDegree = 10;  // 285 functions: three times what any rows determine

// x, y, z, x^2, y^2, z^2, xy, xz, yz: what distorts a field to second order.
constexpr int kNumFieldFunctions = 9;
Eigen::VectorXd FieldFunctions(const Vector3<double>& place);
// A place, or where its ray leaves a ball of that radius: what is described by place says nothing beyond.
Vector3<double> WithinReach(const Vector3<double>& place, double reach);

// Of the nominal arm at these joint values (SI): the direction of gravity in the flange, and where the flange is, m.
Vector3<double> DownInFlange(const Chain& chain, const Eigen::VectorXd& q, const Vector3<double>& down_in_base);
Vector3<double> FlangePlace(const Chain& chain, const Eigen::VectorXd& q);

// The sum of the sizes of some forces, N.
double SizeOfForces(const std::vector<AppliedWrench>& wrenches);

}  // namespace sagitta
