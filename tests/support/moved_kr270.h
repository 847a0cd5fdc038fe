// A KR 270 of one station or more whose joints stand elsewhere than its rows say: campaigns of the tests that look for
// what a model lacks.
#pragma once

#include "tests/support/kr270_experiment.h"

namespace sagitta::test {

inline Kr270Design CampaignOf(int configurations, int stations, double sigma, std::uint64_t seed) {
  Kr270Design design;
  design.configurations = configurations;
  design.stations = stations;
  design.sigma = sigma;
  design.seed = seed;
  return design;
}

inline Robot Kr270Robot() {
  Robot robot;
  robot.name = "KR 270";
  robot.chain = Kr270Chain();
  return robot;
}

// Each configuration is shot once more, after all the others.
inline void VisitAgain(const Kr270Design& design, Measurements* data) {
  for (int c = 0; c < design.configurations; ++c) {
    Configuration again = data->configurations[c];
    again.id += "-again";
    Shot shot = data->shots[c];
    shot.configuration = static_cast<int>(data->configurations.size());
    data->configurations.push_back(again);
    AddShot(shot, 3, design.sigma, data);
  }
}

// `data` with points that are measured once `move` has changed the joint values of each configuration.
template <typename Move>
Measurements MeasuredAfter(Measurements data, double sigma, std::uint64_t noise_seed, const Move& move) {
  Measurements moved = data;
  for (Configuration& configuration : moved.configurations) move(&configuration.q);
  MeasureKr270(Kr270Truth(), sigma, noise_seed, &moved);
  for (size_t i = 0; i < data.observations.size(); ++i) {
    data.observations[i].point_in_station = moved.observations[i].point_in_station;
  }
  return data;
}

template <typename Move>
Measurements MeasuredAfter(const Kr270Design& design, std::uint64_t noise_seed, const Move& move) {
  return MeasuredAfter(DesignMeasurements(design), design.sigma, noise_seed, move);
}

}  // namespace sagitta::test
