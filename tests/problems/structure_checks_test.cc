// Robots and rows that do not fit together are refused with the item's name, whoever made them: readers of files see to
// most of it, callers with data in memory may not.
#include "problems/structure_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "models/constants.h"
#include "models/effects/catalogue.h"
#include "problems/calibration_problem.h"
#include "problems/input_error.h"
#include "problems/io/robot_file.h"
#include "tests/support/in_memory.h"

namespace sagitta::structure_checks_test {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Given {
  Robot robot = test::ArmInMemory();
  Measurements data = test::ReadingsInMemory(test::ArmInMemory());
  Experiment experiment;
};

// What MakeCalibrationProblem says of it; "" where it refuses nothing.
std::string Refusal(const std::function<void(Given*)>& spoil) {
  Given given;
  spoil(&given);
  try {
    MakeCalibrationProblem(given.robot, given.data, given.experiment);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Structure, RowsOfNoFileAreSound) {
  EXPECT_EQ(Refusal([](Given*) {}), "");
}

TEST(Structure, AJointThatIsHeldHasItsOneValue) {
  const auto hold = [](Given* g, double value) {
    g->robot.chain.joints[2].min = g->robot.chain.joints[2].max = value;
    for (Configuration& configuration : g->data.configurations) configuration.q[2] = value;
  };
  EXPECT_EQ(Refusal([&](Given* g) { hold(g, 0.5); }), "");
  EXPECT_THAT(Refusal([&](Given* g) {
                hold(g, 0.5);
                g->data.configurations[3].q[2] = 0.25;
              }),
              AllOf(HasSubstr("c3"), HasSubstr("does not move by itself"), HasSubstr("28.6478898, not 14.3239449 deg"),
                    HasSubstr("lower and as its upper limit"), Not(HasSubstr("mimic"))));
  EXPECT_THAT(Refusal([&](Given* g) {
                hold(g, 0.0);
                g->robot.chain.couplings.push_back({2, 1, 1.0});
                g->data.configurations[3].q[2] = 0.25;
              }),
              HasSubstr("<mimic>"));
}

// Three decimals of degrees or mm are what controllers print of it.
TEST(Structure, TheValueOfALockedJointMayBeRounded) {
  Joint locked;
  locked.min = locked.max = 30.0 * kDegree;
  EXPECT_TRUE(locked.Allows(30.0005 * kDegree));
  EXPECT_TRUE(locked.Allows(30.00001 * kDegree));
  EXPECT_FALSE(locked.Allows(30.0006 * kDegree));
  locked.type = JointType::kPrismatic;
  locked.min = locked.max = 1.25;
  EXPECT_TRUE(locked.Allows(1.2500005));
  EXPECT_FALSE(locked.Allows(1.2500006));
}

TEST(Structure, OneJointValuePerJoint) {
  EXPECT_THAT(Refusal([](Given* g) { g->data.configurations[3].q.conservativeResize(5); }),
              AllOf(HasSubstr("configuration c3"), HasSubstr("5 joint values"), HasSubstr("6 joints")));
  EXPECT_THAT(Refusal([](Given* g) { g->data.configurations[3].q.resize(0); }), HasSubstr("configuration c3"));
  EXPECT_THAT(Refusal([](Given* g) { g->data.shots[2].joint_torques = Eigen::VectorXd::Ones(2); }),
              AllOf(HasSubstr("shot 2"), HasSubstr("2 joint torques")));
  EXPECT_THAT(Refusal([](Given* g) {
                g->data.shots[2].approach = {1, 0};
              }),
              AllOf(HasSubstr("shot 2"), HasSubstr("2 directions of approach")));
  EXPECT_THAT(Refusal([](Given* g) { g->data.shots[2].approach = {7, 0, 0, 0, 0, 0}; }), HasSubstr("shot 2"));
}

TEST(Structure, EveryIndexLeadsSomewhere) {
  for (const int wrong : {-1, 99999}) {
    EXPECT_THAT(Refusal([&](Given* g) { g->data.observations[4].shot = wrong; }),
                AllOf(HasSubstr("observation 4"), HasSubstr("shot " + std::to_string(wrong))));
    EXPECT_THAT(Refusal([&](Given* g) { g->data.observations[4].marker = wrong; }),
                AllOf(HasSubstr("observation 4"), HasSubstr("marker " + std::to_string(wrong))));
    EXPECT_THAT(Refusal([&](Given* g) { g->data.shots[4].configuration = wrong; }),
                AllOf(HasSubstr("shot 4"), HasSubstr("configuration " + std::to_string(wrong))));
    EXPECT_THAT(Refusal([&](Given* g) { g->data.shots[4].station = wrong; }),
                AllOf(HasSubstr("shot 4"), HasSubstr("station " + std::to_string(wrong))));
    EXPECT_THAT(Refusal([&](Given* g) { g->data.shots[4].observations.push_back(wrong); }),
                AllOf(HasSubstr("shot 4"), HasSubstr("observation " + std::to_string(wrong))));
  }
  EXPECT_THAT(Refusal([](Given* g) { g->data.observations[4].file = 0; }),
              AllOf(HasSubstr("observation 4"), HasSubstr("file 0 does not exist, there are 0")));
  EXPECT_THAT(Refusal([](Given* g) {
                g->data.files.resize(1);
                g->data.observations[4].file = 0;
                g->data.observations[4].row = 3;
              }),
              AllOf(HasSubstr("observation 4"), HasSubstr("row of its file 3")));
}

// Targets have no marker; what is fitted has one.
TEST(Structure, ARowOfTheFlangeIsOnlyKnown) {
  Given given;
  given.data.markers.clear();
  for (Observation& row : given.data.observations) row.marker = -1;
  EXPECT_NO_THROW(MakeKnownProblem(given.robot, given.data, given.experiment, {}));
  EXPECT_THROW(MakeCalibrationProblem(given.robot, given.data, given.experiment), InputError);
  given.data.observations[4].marker = 2;
  EXPECT_THROW(MakeKnownProblem(given.robot, given.data, given.experiment, {}), InputError);
}

TEST(Structure, ShotsListTheirRows) {
  EXPECT_THAT(Refusal([](Given* g) { g->data.shots[1].observations.clear(); }),
              AllOf(HasSubstr("observation 3"), HasSubstr("shot 1")));
  EXPECT_THAT(Refusal([](Given* g) { g->data.shots[1].observations.push_back(4); }),
              AllOf(HasSubstr("observation 4"), HasSubstr("more than once")));
  EXPECT_THAT(Refusal([](Given* g) { g->data.observations[4].shot = 7; }),
              AllOf(HasSubstr("shot 1"), HasSubstr("observation 4, which is of shot 7")));
}

TEST(Structure, NamesAreThereAndDiffer) {
  EXPECT_THAT(Refusal([](Given* g) { g->data = Measurements(); }), HasSubstr("no row"));
  EXPECT_THAT(Refusal([](Given* g) { g->robot = Robot(); }), HasSubstr("no joint"));
  EXPECT_THAT(Refusal([](Given* g) { g->data.markers[1] = "M1"; }), AllOf(HasSubstr("markers"), HasSubstr("'M1'")));
  EXPECT_THAT(Refusal([](Given* g) { g->data.stations.push_back("S1"); }), HasSubstr("stations"));
  EXPECT_THAT(Refusal([](Given* g) { g->robot.chain.joints[1].name = "A1"; }),
              AllOf(HasSubstr("joints of the robot"), HasSubstr("'A1'")));
  EXPECT_THAT(Refusal([](Given* g) { g->robot.chain.joints[1].name = ""; }), HasSubstr("one has no name"));
  EXPECT_THAT(Refusal([](Given* g) { g->data.markers.push_back("M4"); }), HasSubstr("marker 'M4' is listed"));
  EXPECT_THAT(Refusal([](Given* g) { g->data.stations.push_back("S4"); }), HasSubstr("station 'S4' is listed"));
}

TEST(Structure, AChainWithADefectIsRefused) {
  const auto move_joint = [](int to) {
    return [to](Given* g) {
      for (ElementaryTransform& transform : g->robot.chain.transforms) {
        if (transform.joint == 1) transform.joint = to;
      }
    };
  };
  EXPECT_THAT(Refusal(move_joint(0)), HasSubstr("joint 'A1' is on more than one transform"));
  EXPECT_THAT(Refusal(move_joint(17)), HasSubstr("joint 17 does not exist"));
  EXPECT_THAT(Refusal([](Given* g) { g->robot.chain.transforms[0].sign = 3.0; }), HasSubstr("neither 1 nor -1"));
  EXPECT_THAT(Refusal([](Given* g) { g->robot.chain.couplings = {{2, 9, 1.0}}; }), HasSubstr("driver 9"));
  EXPECT_THAT(Refusal([](Given* g) { g->robot.compliances = {{9, {{0.0, 1e-6}}, false}}; }), HasSubstr("joint 9"));
  EXPECT_THAT(Refusal([](Given* g) { g->robot.compliances = {{1, {}, false}}; }), HasSubstr("no value"));
  EXPECT_THAT(
      Refusal([](Given* g) { g->robot.gravity_compensator = GravityCompensator{9, 0.1, 0.1, 0.1, 0.5, 1e4, true}; }),
      AllOf(HasSubstr("gravity compensator"), HasSubstr("joint 9")));
}

// The table is what is written, the chain is what is calibrated.
TEST(Structure, AChainIsThatOfItsTable) {
  const auto a_length = [](Given* g) -> ElementaryTransform* {
    return &g->robot.chain.transforms[static_cast<size_t>(g->robot.chain.FindError("A2.a"))];
  };
  const auto refused = AllOf(HasSubstr("Robot::dh"), HasSubstr("ChainFromDhTable"));
  EXPECT_THAT(Refusal([&](Given* g) { a_length(g)->nominal += 0.01; }), refused);
  EXPECT_THAT(Refusal([&](Given* g) { a_length(g)->error = "A2.other"; }), refused);
  EXPECT_THAT(Refusal([](Given* g) { g->robot.chain.joints[5].name = "J6"; }), refused);
  EXPECT_THAT(Refusal([](Given* g) {
                g->robot.chain.transforms[static_cast<size_t>(g->robot.chain.JointTransform(5))].sign = -1.0;
              }),
              refused);
  EXPECT_THAT(Refusal([](Given* g) {
                g->robot.chain.transforms.push_back({Motion::kTranslation, Axis::kX, 0.1, -1, 1.0, ""});
              }),
              refused);
  EXPECT_EQ(Refusal([&](Given* g) {
              a_length(g)->nominal += 0.01;
              g->robot.dh.reset();
            }),
            "");
  EXPECT_EQ(Refusal([](Given* g) { g->robot = WithGeometricErrors(g->robot, {{"A2.a", 0.01}}); }), "");
}

TEST(Structure, CompliancesAreThoseOfAFile) {
  const auto with = [](const std::vector<JointCompliance>& compliances) {
    return Refusal([&](Given* g) { g->robot.compliances = compliances; });
  };
  EXPECT_EQ(with({{1, {{0.0, 1e-6}}, false}, {2, {{-1.0, 1e-6}, {1.0, 2e-6}}, true}}), "");
  EXPECT_THAT(with({{1, {{0.0, 1e-6}}, false}, {1, {{0.0, 1e-6}}, false}}), HasSubstr("'A2' has two compliances"));
  EXPECT_THAT(with({{1, {{0.0, 1e-6}, {1.0, 1e-6}}, false}}), HasSubstr("no table"));
  EXPECT_THAT(with({{1, {{1.0, 1e-6}, {1.0, 2e-6}}, true}}), HasSubstr("have to increase"));
  EXPECT_THAT(with({{1, {{0.0, -1e-6}}, false}}), HasSubstr("not below 0"));
}

TEST(Structure, PriorsBelongToValues) {
  const auto spring = [](const std::vector<double>& sigmas) {
    return Refusal([&](Given* g) {
      g->robot.gravity_compensator = GravityCompensator{1, 0.1, 0.1, 0.1, 0.5, 1e4, true};
      g->robot.gravity_compensator->prior_sigmas = sigmas;
    });
  };
  EXPECT_EQ(spring({0.0, 0.0, 0.0, 0.0, 10.0}), "");
  EXPECT_THAT(spring({1.0, 1.0}), HasSubstr("2 standard deviations of priors, there are 5 values"));
  EXPECT_THAT(spring({1.0, 1.0, 1.0, 1.0, -1.0}), HasSubstr("negative"));
  EXPECT_THAT(Refusal([](Given* g) {
                g->robot.effects = {{"joint_harmonic", "A1", {{"order", "1"}}, {0.0, 0.0}, {-1e-5, 0.0}}};
              }),
              HasSubstr("negative"));
}

TEST(Structure, CouplingsAreThoseOfAFile) {
  const auto with = [](const Coupling& coupling) {
    return Refusal([&](Given* g) {
      g->robot.chain.couplings = {coupling};
      g->robot.dh.reset();
    });
  };
  EXPECT_EQ(with({2, 1, -1.0}), "");
  EXPECT_THAT(with({1, 1, -1.0}), HasSubstr("cannot drive itself"));
  EXPECT_THAT(with({2, 1, kNan}), HasSubstr("ratio"));
  EXPECT_THAT(Refusal([&](Given* g) {
                g->robot.chain.couplings = {{2, 1, -1.0}, {2, 1, 0.5}};
                g->robot.dh.reset();
              }),
              HasSubstr("would add up"));
}

TEST(Structure, NamesCanBeWritten) {
  EXPECT_THAT(Refusal([](Given* g) { g->data.markers[1] = "M\n2"; }), HasSubstr("control character"));
}

TEST(Structure, RotationsAreRotations) {
  const auto with = [](const Matrix3<double>& rotation, double sigma) {
    return Refusal([&](Given* g) {
      Observation turn = g->data.observations[4];
      turn.kind = ReadingKind::kRotation;
      turn.partner = 4;
      turn.mutable_rotation()->in_station = rotation;
      turn.mutable_rotation()->sigma.setConstant(sigma);
      const int place = static_cast<int>(g->data.observations.size());
      g->data.observations[4].partner = place;
      g->data.shots[static_cast<size_t>(turn.shot)].observations.push_back(place);
      g->data.observations.push_back(turn);
    });
  };
  const Matrix3<double> one = Matrix3<double>::Identity();
  EXPECT_EQ(with(one, 1e-4), "");
  for (const double factor : {0.0, -1.0, 2.0}) EXPECT_THAT(with(factor * one, 1e-4), HasSubstr("no rotation matrix"));
  EXPECT_THAT(with(one, -1e-4), HasSubstr("standard deviation"));
}

TEST(Structure, AStatedNoiseIsStated) {
  EXPECT_THAT(Refusal([](Given* g) { g->experiment.noise.from = NoiseSpec::From::kSigma; }), HasSubstr("noise.sigma"));
}

TEST(Structure, EffectsAreKnownAndWhole) {
  const auto with = [](const EffectSpec& spec) { return Refusal([&](Given* g) { g->robot.effects = {spec}; }); };
  EXPECT_EQ(with({"joint_harmonic", "A1", {{"order", "1"}}, {}}), "");
  EXPECT_THAT(with({"nope", "A1", {}, {}}), HasSubstr("there is no effect 'nope'"));
  EXPECT_THAT(with({"joint_harmonic", "A9", {{"order", "1"}}, {}}), HasSubstr("no joint 'A9'"));
  EXPECT_THAT(with({"joint_harmonic", "A1", {{"order", "abc"}}, {}}), HasSubstr("'order' cannot be 'abc'"));
  for (const char* order : {"-5", "0", "1000000"}) {
    EXPECT_THAT(with({"joint_harmonic", "A1", {{"order", order}}, {}}), HasSubstr("'order' cannot be"));
  }
  EXPECT_THAT(with({"joint_harmonic", "A1", {{"order", "1"}, {"ordre", "2"}}, {}}), HasSubstr("no setting 'ordre'"));
  EXPECT_THAT(with({"joint_coupling", "A3", {{"driver", "A9"}}, {}}), HasSubstr("no joint 'A9'"));
  EXPECT_THAT(with({"hysteresis", "A1", {}, {}}), HasSubstr("setting 'width_deg' is missing"));
  EXPECT_THAT(with({"joint_harmonic", "A1", {{"order", "1"}}, {1e-5}}), HasSubstr("1 values"));
  EXPECT_THAT(Refusal([](Given* g) {
                g->robot.effects.assign(2, EffectSpec{"joint_harmonic", "A1", {{"order", "1"}}, {}});
              }),
              HasSubstr("stands twice"));
}

// An effect of the catalogue under another name.
EffectDefinition OwnEffect(const std::string& name) {
  EffectDefinition definition = *FindEffect("joint_harmonic");
  definition.name = name;
  return definition;
}

TEST(Structure, AnOwnEffectHasANameOfItsOwn) {
  const EffectDefinition mine = OwnEffect("mine"), same_name = OwnEffect("joint_harmonic");
  EffectDefinition empty = OwnEffect("empty");
  empty.apply = nullptr;
  EXPECT_EQ(Refusal([&](Given* g) { g->robot.own_effects = {&mine}; }), "");
  EXPECT_THAT(Refusal([&](Given* g) { g->robot.own_effects = {&same_name}; }),
              AllOf(HasSubstr("own effect 'joint_harmonic'"), HasSubstr("catalogue")));
  EXPECT_THAT(Refusal([&](Given* g) { g->robot.own_effects = {&mine, &mine}; }), HasSubstr("twice"));
  EXPECT_THAT(Refusal([&](Given* g) { g->robot.own_effects = {&empty}; }), HasSubstr("lacks"));
  EXPECT_THAT(Refusal([](Given* g) { g->robot.own_effects = {nullptr}; }), HasSubstr("null"));
}

// Of a robot that uses the effect, which is named "mine".
std::string RefusalOfUse(const EffectDefinition& mine) {
  try {
    return Refusal([&](Given* g) {
      g->robot.own_effects = {&mine};
      g->robot.effects = {{"mine", "A1", {{"order", "1"}}, {}}};
    });
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
}

// What it adds in a shot is looked at when it is added.
TEST(Structure, TermsOfAnOwnEffectLeadSomewhere) {
  static double factor = 1.0;
  static int transform = 0, beyond = 0;
  EffectDefinition mine = OwnEffect("mine");
  mine.apply = [](const EffectContext& context, ShotTerms* terms) {
    terms->slots.push_back({transform, context.first_parameter + beyond, factor});
  };
  const auto words = [&](int at, int parameter, double times) {
    transform = at, beyond = parameter, factor = times;
    return RefusalOfUse(mine);
  };
  EXPECT_EQ(words(0, 0, 1.0), "");
  EXPECT_THAT(words(1000, 0, 1.0), AllOf(HasSubstr("effect 'mine'"), HasSubstr("transform 1000")));
  EXPECT_THAT(words(0, 1000, 1.0), HasSubstr("names parameter"));
  EXPECT_THAT(words(0, 0, kNan), HasSubstr("number that is none"));
}

// One number per shot: fewer would be read past their end.
TEST(Structure, AnOwnEffectRemembersEachShot) {
  static size_t missing = 0;
  EffectDefinition mine = OwnEffect("mine");
  mine.remember = [](const Robot&, const EffectSpec&, const std::vector<const ShotConditions*>& campaign) {
    return std::vector<double>(campaign.size() - missing, 0.0);
  };
  const auto words = [&](size_t fewer) {
    missing = fewer;
    return RefusalOfUse(mine);
  };
  EXPECT_EQ(words(0), "");
  EXPECT_THAT(words(1), AllOf(HasSubstr("effect 'mine'"), HasSubstr("remember"), HasSubstr("one per shot")));
}

// What residuals.csv could not be read back with.
TEST(Structure, TextsCanBeWritten) {
  EXPECT_EQ(Refusal([](Given* g) { g->data.configurations[0].id = "c\u00e9 0"; }), "");
  EXPECT_THAT(Refusal([](Given* g) { g->data.configurations[0].id = "c\n0"; }),
              AllOf(HasSubstr("its id 'c\\n0'"), HasSubstr("control character")));
  EXPECT_THAT(Refusal([](Given* g) { g->data.markers[0] = "\xff\xfe"; }), HasSubstr("no text in UTF-8"));
  EXPECT_THAT(Refusal([](Given* g) { g->data.shots[2].visit = "\xff"; }),
              AllOf(HasSubstr("shot 2"), HasSubstr("its visit"), HasSubstr("no text in UTF-8")));
  EXPECT_THAT(Refusal([](Given* g) { g->data.shots[2].repeat = "1\t"; }), HasSubstr("its repeat"));
  EXPECT_THAT(Refusal([](Given* g) { g->data.shots[2].load = "\x1b[0m"; }), HasSubstr("its load"));
}

TEST(Structure, ChoicesAreThere) {
  EXPECT_THAT(Refusal([](Given* g) { g->experiment.method.loss = static_cast<LossKind>(99); }),
              AllOf(HasSubstr("loss"), HasSubstr("no choice number 99")));
  EXPECT_THAT(Refusal([](Given* g) { g->experiment.method.covariance = static_cast<CovarianceKind>(-1); }),
              HasSubstr("no choice number -1"));
}

TEST(Structure, ARotationIsAddedToAShotThatIsThere) {
  Measurements data = Given().data;
  EXPECT_THROW(data.AddRotation(static_cast<int>(data.observations.size())), std::invalid_argument);
  data.observations.push_back(data.observations[0]);
  data.observations.back().shot = static_cast<int>(data.shots.size());
  EXPECT_THROW(data.AddRotation(static_cast<int>(data.observations.size()) - 1), std::invalid_argument);
  const size_t rows = data.observations.size();
  EXPECT_EQ(data.AddRotation(0).partner, 0);
  EXPECT_EQ(data.observations.size(), rows + 1);
}

TEST(Structure, EffectsThatAreAddedAreThere) {
  Given given;
  const CalibrationProblem problem = MakeCalibrationProblem(given.robot, given.data, given.experiment);
  EXPECT_THROW(problem.WithEffects({{"nonsense", "A1", {}, {}}}), InputError);
  EXPECT_THROW(problem.WithEffects({{"joint_harmonic", "A1", {{"order", "1"}}, {1.0}}}), InputError);
  Robot robot = given.robot;
  robot.effects = {{"nonsense", "A1", {}, {}}};
  EXPECT_THROW(ForwardModel{robot}, std::invalid_argument);
  EffectDefinition empty = OwnEffect("mine");
  empty.parameters = nullptr;
  EXPECT_THROW(ReadRobotText(RobotToYaml(given.robot), "robot", {&empty}), InputError);
}

TEST(Structure, NumbersAreNumbers) {
  for (const double wrong : {kNan, kInfinity, -kInfinity, 1e200}) {
    EXPECT_THAT(Refusal([&](Given* g) { g->data.configurations[3].q[2] = wrong; }), HasSubstr("configuration c3"));
    EXPECT_THAT(Refusal([&](Given* g) { g->robot.chain.transforms[2].nominal = wrong; }), HasSubstr("transform 2"));
    EXPECT_THAT(Refusal([&](Given* g) {
                  g->robot.compliances = {{1, {{0.0, wrong}}, false}};
                }),
                HasSubstr("compliance 0"));
    EXPECT_THAT(Refusal([&](Given* g) {
                  g->robot.effects = {{"joint_harmonic", "A1", {{"order", "1"}}, {wrong, 0.0}}};
                }),
                HasSubstr("joint_harmonic"));
    EXPECT_THAT(Refusal([&](Given* g) { g->data.shots[5].wrench.force.x() = wrong; }), HasSubstr("shot 5"));
    EXPECT_THAT(Refusal([&](Given* g) { g->data.observations[4].sigma.x() = wrong; }), HasSubstr("observation 4"));
  }
  EXPECT_THAT(Refusal([](Given* g) { g->data.observations[4].sigma.x() = -1e-5; }), HasSubstr("observation 4"));
  EXPECT_THAT(Refusal([](Given* g) { g->data.observations[4].sigma.x() = 1e-12; }), HasSubstr("standard deviation"));
  EXPECT_THAT(Refusal([](Given* g) { g->robot.chain.joints[2].min = kNan; }), HasSubstr("joint A3"));
  EXPECT_THAT(Refusal([](Given* g) {
                g->data.shots[5].has_time = true;
                g->data.shots[5].time = 1e300;
              }),
              HasSubstr("shot 5"));
  for (const double wrong : {kInfinity, -kInfinity, 1e200}) {
    EXPECT_THAT(Refusal([&](Given* g) { g->data.observations[4].point_in_station.x() = wrong; }),
                HasSubstr("observation 4"));
  }
  // Not measured: it can be planned and predicted with.
  EXPECT_EQ(Refusal([](Given* g) { g->data.observations[4].point_in_station.x() = kNan; }), "");
}

TEST(RowsOfNoFile, AreNamedByWhatTheyAre) {
  Measurements data = test::ReadingsInMemory(test::ArmInMemory());
  EXPECT_EQ(data.SourceOf(data.observations[4]), "configuration c1, marker M2");
  data.shots[1].repeat = "2";
  data.shots[1].load = "W";
  data.stations.push_back("S2");
  EXPECT_EQ(data.SourceOf(data.observations[4]), "configuration c1, repeat 2, load W, station S1, marker M2");
  EXPECT_EQ(data.WhereOf(data.shots[0], "load").file, "configuration c0, station S1, marker M1");
  EXPECT_EQ(data.WhereOf(Shot(data.shots[0]), "load").key, "load");
}

TEST(RowsOfNoFile, ErrorsNameThem) {
  EXPECT_THAT(Refusal([](Given* g) { g->data.observations[4].sigma.setZero(); }),
              AllOf(HasSubstr("configuration c1, marker M2"), HasSubstr("this one has none")));
  EXPECT_THAT(Refusal([](Given* g) {
                for (Shot& shot : g->data.shots) shot.load = "W";
                g->data.shots[2].wrench.force.z() = -300.0;
              }),
              AllOf(HasSubstr("configuration c0"), HasSubstr("no stated point")));
  EXPECT_THAT(Refusal([](Given* g) { g->experiment.torques_measured = true; }),
              AllOf(HasSubstr("configuration c0"), HasSubstr("measured joint torques")));
  EXPECT_THAT(Refusal([](Given* g) {
                g->robot.effects = {{"thermal_growth", "robot", {}, {}}};
              }),
              AllOf(HasSubstr("configuration c0"), HasSubstr("temperature_degC")));
}

}  // namespace
}  // namespace sagitta::structure_checks_test
