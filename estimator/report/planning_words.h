// What a plan says of itself: what was assumed and checked, its order, how near to the best it is. Numbers come in SI.
#pragma once

#include <string>
#include <vector>

#include "estimator/planning/plan.h"

namespace sagitta {

// What a plan by this criterion makes small or large.
std::string InWords(CriterionKind kind);

// share: of the way in the order in which poses were found.
std::string OrderIsMixed();
std::string OrderIsShort(double share);

// Effects that go with the order of the rows; m, at the test points, model error included: as searched, and in the
// order that is written; asked: m, 0 where a number of poses was.
std::string JudgedInItsOrder(const std::vector<std::string>& effects, double searched, double written, double asked);

// What the plan assumed, after what its scene already says.
std::vector<std::string> AssumptionsInWords(const Plan& plan, bool candidates_are_drawn);
// Unknowns of stations and markers that only test poses see, coordinates of these points, and what is left of them; 0:
// they do not count.
std::string RegisteredOnTests(int unknowns, int coordinates, int left);
std::string PlacesFitReadings();
std::string PlacesAreStated();
std::string PatternsLeftOut(int left_out, int offered);
// are_drawn: the accuracy is asked at drawn poses in place of these.
std::string FewTestPoses(size_t poses, bool are_drawn);
std::string FewTestPosesDrawn(size_t poses);
std::string RowsWithoutReading(size_t rows);
// what: "marker M2", "load V250", … that no row of the candidates has.
std::string CandidatesLack(const std::vector<std::string>& what);
std::string CandidatesStateNoSigma(int rows);
// least, largest: m, of rows that are measured alike.
std::string SigmasOfAlikeRowsDiffer(double least, double largest);
// What goes with time or temperature is known as well as predicted at those that the plan assumes.
std::string ConditionsAreAssumed(bool time, bool temperature);
// A repeatability that is to be estimated, and weights that are not the noise's: what the plan counts instead.
std::string RepeatabilityIsNotCounted();
std::string BestWeightsAreAssumed(Weights weights);
// why: as the split is refused.
std::string NothingIsHeldOut(const std::string& why);

// What is not checked of each pose: `what` follows.
std::string BodiesAreNotStated();
std::string BoxesAreNotStated();

// Why a pose cannot be used, and what of it is checked.
std::string BelowItsLimit(const std::string& joint);
std::string AboveItsLimit(const std::string& joint);
std::string OutsideItsRange(const std::string& joint);
std::string AtNoneOfItsLevels(const std::string& joint);
std::string LeavesItsBoxes(const std::string& what);
std::string OutOfRange(const std::string& marker, const std::string& station);
std::string OutOfElevations(const std::string& marker, const std::string& station);
std::string FacesAway(const std::string& reflector, const std::string& station);
std::string StandsBetween(const std::string& body, const std::string& station, const std::string& marker);
std::string FloorIsChecked(const std::string& of_what);
std::string StayInIsChecked();
std::string KeepOutIsChecked(const std::string& of_what);
std::string CapsulesAreChecked();
std::string SightIsChecked(const std::string& station);
std::string SightsAreOpen(const std::string& stations);
std::string WaysAreOpen();
std::string HasNoEquilibrium();

// How near the plan is to the best one; of a criterion without a certificate, why that is not known.
std::string CertificateInWords(const Plan& plan);
// What the accuracies over the number of poses are, and why the plan's own is another one.
std::string CurveInWords(const Plan& plan);
// What the numbers of a plan that distinguishes effects mean.
std::string SeparationInWords();

}  // namespace sagitta
