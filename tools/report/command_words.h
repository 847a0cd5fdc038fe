// What commands say on the terminal of their results. Numbers come in SI.
#pragma once

#include <string>
#include <vector>

#include "estimator/changes/changes.h"
#include "estimator/planning/plan.h"
#include "estimator/sagitta.h"

namespace sagitta {

// Where results went; files: their names, in the order of reading.
std::string NothingIsWritten();
std::string ResultsIn(const std::string& folder, const std::vector<std::string>& files);
// Where results of a validation went to the folder of the estimate.
std::string ReplacedThoseOfTheEstimate(const std::vector<std::string>& files);
// Of files that only some runs write and this one did not: they are there, and nothing that this run says is of them.
std::string OlderFilesIn(const std::string& folder, const std::vector<std::string>& files);

// What an interrupted run of so many trials knows; covered: share.
std::string TrialsAreKept(int done, int trials, double covered, const std::string& folder);

// After a diagnosis that names effects; of_this_campaign: those of them that go with times.
std::string HowToGoOnWithEffects(const std::vector<std::string>& of_this_campaign);

// How far two estimates are apart, and what else may have changed.
std::string ComparisonInWords(const Changes& changes);

// What the columns of the table of methods are.
std::vector<std::string> MethodsLegend();

// What the marks and columns of the table of coverage are; outside: rows of `rows` marked.
std::vector<std::string> CoverageLegend(int outside, size_t rows);

// Of all targets that were solved: largest distance from the target before and after, largest 95 % uncertainty, m.
std::string CompensationInWords(double before, double after, double u95);
// What the figures of corrected targets are figures of.
std::string FlangeOfTheMarkers();

// A plan in a few lines.
std::string PlanInWords(const Plan& plan);

// What 95 % of a quantity are within whose standard deviation was found with so many degrees of freedom; "" where these
// are many, or 0: it is stated.
std::string CoverageInWords(double noise_dof);
// largest: standard deviation of a predicted coordinate, mm; not finite: not known.
std::string PredictedInWords(int points, double largest, double noise_dof, const std::string& file);
std::string SimulatedInWords(int rows, std::uint64_t seed, bool is_exact, const std::string& file);

// A diagnosis against the columns of another simulation. reproduced: RMS distance, m.
std::string AgainstColumns(double reproduced);
std::string FarFromColumns();
std::string CorrectionsToSimulation();
// Comments of YAML files, with their line ends.
std::string NotACalibratedRobot();
std::string LearntFunctionsInFile();

// A robot that is written in another form. Lengths in m.
std::string PlainAndExact();
std::string WithoutBeta(double rms, double largest, double largest_length_change);
std::string KeepControllersLines();
std::string HashIsMissing();  // of a calibration.yaml
std::string ListsAreReplaced(const std::string& file);
std::string MovesAsBefore(double difference);
// Of an effect, m.
std::string CountsFromTurnedAxes(const std::string& effect, double difference);
std::string KeepItsDescription();
// Links of a URDF; others: those it could end at.
std::string ChainRuns(const std::string& base, const std::string& tip, const std::vector<std::string>& others);
// Of a joint of a URDF.
std::string MimicIsACoupling(const std::string& joint, const std::string& driver);
std::string LeftOutOfFormat(const std::string& what);

// Imported files.
std::string RowsAreNoMeasurements(const std::string& what);
std::string NoShippedTables(const std::vector<std::string>& tried);
std::string WhereTablesAre();
std::string OnlyTableThatFits(const std::string& table, const std::string& misfit);
std::string ColumnsFit(const std::string& misfit);
std::string ColumnsFitMostRows(const std::string& misfit);
// Of all readings so many are farther off than the others, whose RMS distance this is; rows: where they stand.
std::string ReadingsAreFarOff(size_t all, const std::string& others, size_t far, const std::string& rows);
std::string TorquesAreCarried();
std::string LoadNeedsPoint(const std::string& load);
std::string WeighedLoadNeedsPoint(const std::string& load, double mass);  // kg
std::string RowsLieApart(int line, const std::string& distance);          // this row and another
std::string TooFewPoses(size_t poses);
std::string StationPerFile();
std::string MarkerPerFile();

}  // namespace sagitta
