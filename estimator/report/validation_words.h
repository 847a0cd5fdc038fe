// The verdict on an estimate in words: how far it may be believed, and what speaks against it. Numbers come in SI.
#pragma once

#include <string>

#include "estimator/agreement/breaks.h"
#include "estimator/validation/prior_conflict.h"
#include "estimator/validation/trust.h"

namespace sagitta {

// Which points that were not fitted are off by more than was predicted for them.
enum class ExcessOf { kNone, kHoldout, kCrossValidation };

// Intervals wider by model error: `median` and `largest` factor, the latter of the parameter `name`.
std::string ModelErrorInWords(double median, double largest, const std::string& name, const std::string& between,
                              ExcessOf excess);

// Reasons not to trust.
std::string NothingChecksIt();
std::string NothingChecksTheMethod();
std::string NothingIsPredictable();
std::string PredictionIsOff(bool is_holdout, double excess, double p_value);
std::string WorseThanNominal(double nominal_rms);
std::string PosesAreTooFew(double nominal_rms, double rms);
std::string NoRedundancy();
std::string BelowAnyInstrument(double rms);
std::string RowsAreSuspect(size_t rows, const std::string& first);
std::string HeldOutIsFitted(int seen, int held_out);
// by_sensor: measured torques drive the deflections.
std::string ComesOutNegative(const std::string& name, double sigmas, bool by_sensor);
// slope: measured over modelled, of the joint of `joints` where it is farthest from 1.
std::string TorquesAreOthers(const std::string& joint, double slope, size_t joints);
std::string WeightsAreWrong(double worse);
// The worst of `all` conflicts.
std::string RowsContradictPrior(const ParameterSet& parameters, const PriorConflict& worst, size_t all);
std::string SomethingMoved(const CalibrationProblem& problem, const Break& found);
// With suspect rows it is these that are to be looked at first.
std::string RobotStillMisses(double distance_rms, bool has_suspects);

// What else limits it: a joint whose axis was never turned, a correction larger than arms need (of coordinate
// `name`, SI).
std::string JointWasNotMeasured(const Joint& joint, double least, double most);
std::string CorrectionIsLarge(const std::string& name, double correction, bool is_length);

// times: the stated standard deviations that the residuals are.
std::string ResidualsRefuteNoise(double times, bool by_repeats);

// times: by which the stated noise is larger than the residuals; rms: of these, m per coordinate.
std::string StatedNoiseIsTooLarge(double times, double rms);

// better: share by which errors have to differ to be called better; not_measured: directions that the data left open.
std::string VerdictInWords(const Trust& trust, double significance, double better, size_t not_measured);

// Points that no fold predicts; empty: none.
std::string LeftOutInWords(const Unpredictable& left_out);

// How a suspect row would fit; axes: 0 to 2.
std::string FitsTurned(int axis);
std::string FitsExchanged(int axis, int other);
std::string FitsShifted(int axis, bool to_the_right);
std::string FitsInMetres();
std::string FitsInThousandths();
std::string FitsInInches();
// size: by which an outlier is off, m; of an exchange the other marker and its row.
std::string OutlierIsOff(double size);
std::string FitsAsMarker(const std::string& marker, const std::string& row);
std::string FitsConfiguration(const std::string& configuration, const std::string& row);
std::string FitsStation(const std::string& station);
// times: the median of all distances.
std::string RowIsOff(double distance, double times);
std::string MeasureAgain();
std::string ReadingIsLost();  // x, y and z are one number

// Why there is no pose repeatability, or why the one there is comes out small; "": neither.
std::string RepeatabilityIsLimited(const PoseRepeatability& repeatability);

}  // namespace sagitta
