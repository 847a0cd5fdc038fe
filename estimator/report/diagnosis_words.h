// What a diagnosis says to people: the same sentences for the terminal, the report and the words in diagnosis.json.
#pragma once

#include <string>
#include <vector>

#include "estimator/diagnosis/diagnose.h"

namespace sagitta {

// Files of a diagnosis that its words name.
constexpr char kNextFile[] = "next.csv";
constexpr char kLearntFile[] = "robot.learnt.yaml";
constexpr char kNextRobotFile[] = "robot.next.yaml";  // where effects go with times of this campaign
constexpr char kLearntEstimateFile[] = "estimate.learnt.json";

// "51 %"; below and above what percents can say in words.
std::string Percent(double probability);
// Where it is only said to be above 99.9 %.
bool IsNearlyCertain(double probability);
// "periodic joint error (joint_harmonic, A3, order 1)"; effects of the robot file included.
std::string Title(const Robot& robot, const EffectSpec& spec);
// The same for the axis of a picture, target first: "A3 joint_harmonic, order 1".
std::string ShortTitle(const Robot& robot, const EffectSpec& spec);
// The verdict as one sentence or two; as lines, five at most: the first, then causes, strongest first, each with its
// share of the gap on untouched rows.
std::string VerdictInWords(const Diagnosis& diagnosis);
std::vector<std::string> VerdictLines(const Diagnosis& diagnosis);
std::string EffectInWords(const Robot& robot, const FoundEffect& effect);
std::string AlternativeInWords(const Robot& robot, const Alternative& alternative);
// Poses, loads or columns that would distinguish this effect from another.
std::string SeparateBy(const Robot& robot, const Alternative& alternative);
std::string HalvesInWords(const Confirmation& confirmation);
// What a rest without a name depends on.
std::string UnexplainedInWords(const Diagnosis& d);
// What the learnt functions do; only where there are any.
std::string LearntInWords(const Diagnosis& d);
std::string FlipInWords(const Robot& robot, const ReportedFlip& flip);
// "periodic joint error on A1, A2 and A3".
std::string GroupInWords(const Diagnosis& diagnosis, const EffectGroup& group);
std::string ShareInWords(const WhereShare& share);

// Whether the data determine this parameter of the effect; the others are held near neutral.
bool IsDetermined(const FoundEffect& effect, const ParameterEstimate& row);

std::string DiagnosisToText(const Diagnosis& diagnosis);

}  // namespace sagitta
