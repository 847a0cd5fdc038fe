#include "problems/choices.h"

namespace sagitta {

std::string WordOf(Weights weights) {
  switch (weights) {
    case Weights::kSigma:
      return "sigma";
    case Weights::kEqual:
      return "equal";
    case Weights::kEq14:
      return "eq14";
  }
  return "";
}

std::string WordOf(CovarianceKind kind) {
  switch (kind) {
    case CovarianceKind::kModel:
      return "model";
    case CovarianceKind::kSandwich:
      return "sandwich";
    case CovarianceKind::kBootstrap:
      return "bootstrap";
    case CovarianceKind::kProfile:
      return "profile";
  }
  return "";
}

std::string WordOf(BootstrapKind kind) {
  switch (kind) {
    case BootstrapKind::kAutomatic:
      return "automatic";
    case BootstrapKind::kParametric:
      return "parametric";
    case BootstrapKind::kConfigurations:
      return "configurations";
  }
  return "";
}

std::string WordOf(LossKind kind) {
  switch (kind) {
    case LossKind::kNone:
      return "none";
    case LossKind::kHuber:
      return "huber";
    case LossKind::kCauchy:
      return "cauchy";
  }
  return "";
}

std::string WordOf(ResidualGroup group) {
  switch (group) {
    case ResidualGroup::kAxis:
      return "axis";
    case ResidualGroup::kConfigAxis:
      return "config-axis";
    case ResidualGroup::kMarkerAxis:
      return "marker-axis";
    case ResidualGroup::kStationAxis:
      return "station-axis";
    case ResidualGroup::kResidual:
      return "residual";
  }
  return "";
}

std::string WordOf(SpringEnd end) {
  switch (end) {
    case SpringEnd::kLever:
      return "lever";
    case SpringEnd::kAnchor:
      return "anchor";
    case SpringEnd::kNone:
      return "none";
  }
  return "";
}

}  // namespace sagitta
