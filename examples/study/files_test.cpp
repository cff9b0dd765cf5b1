// SPDX-License-Identifier: MIT
//
// Files of phymul-study: what is read, what is refused and how, and results that survive a killed process.
#include <gtest/gtest.h>
#include <phymul/error.h>
#include <phymul/pml.h>
#include <phymul/shapes.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "file.h"
#include "journal.h"
#include "measurement.h"
#include "scene.h"

namespace {

namespace fs = std::filesystem;

class Folder {
 public:
  Folder()
      : path_(fs::temp_directory_path() /
              ("phymul_study_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) +
               std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(file(name), std::ios::binary) << text;
    return file(name);
  }

 private:
  fs::path path_;
};

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class Do>
std::string error_of(Do&& what) {
  try {
    what();
  } catch (const phymul::Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(StudyFile, ReadsWhatIsDocumented) {
  const Folder folder;
  const Study study = read_study(folder.write("a.study",
                                              "# a comment\n"
                                              "run body.msh --gravity 0 0 {-9.81*g}   # and another\n"
                                              "run --fix \"fixed side\" --young {E}\n"
                                              "parameter g list 0.1 1\n"
                                              "parameter E range 2e3 4e3 3\n"
                                              "parameter tilt normal 0 5\n"
                                              "samples 20 seed 4\n"
                                              "target tip point 0 0 0.1\n"
                                              "target all group \"fixed side\"\n"
                                              "tolerance 1e-6\n"));
  EXPECT_EQ(study.words, (std::vector<std::string>{"body.msh", "--gravity", "0", "0", "{-9.81*g}", "--fix",
                                                   "fixed side", "--young", "{E}"}));
  EXPECT_EQ(study.parameters[1].values, (std::vector<double>{2e3, 3e3, 4e3}));
  EXPECT_EQ(study.samples, 20);
  EXPECT_EQ(study.seed, 4);
  EXPECT_EQ(study.targets[1].group, "fixed side");
  EXPECT_EQ(study.tolerance, 1e-6);
  EXPECT_EQ(scene_words(study, {0.5, 2.5e3, 0.0})[4], "-4.905");
  EXPECT_EQ(scene_words(study, {0.5, 2.5e3, 0.0})[8], "2500");
}

TEST(StudyFile, RefusesWithFileLineAndWhatWasExpected) {
  const std::string good = "run body.msh\ntarget a group b\n";
  const std::pair<std::string, std::string> refused[] = {
      {"", "a.study: expected a line \"run\""},
      {"run body.msh\n", "a.study: expected a line \"target\""},
      {good + "parameters E list 1\n", "a.study:3: unknown key \"parameters\"; expected run, parameter,"},
      {good + "parameter E list\n", "a.study:3: expected: parameter NAME list|range|"},
      {good + "parameter E gauss 1 2\n", "got \"gauss\""},
      {good + "parameter E range 1 2 1\n", "a.study:3: expected the count, a whole number of 2 to 1e9, got 1"},
      {good + "parameter E range 1 2 2.5\n", "a whole number of 2 to 1e9, got 2.5"},
      {good + "parameter E range 1 2 1e9\n", "a.study:3: expected: parameter NAME range from to count, count at most"},
      {good + "run --fix \"fixed side\n", "a.study:3: expected a second \" at the end of the word"},
      {good + "parameter E uniform 2 1\n", "from < to"},
      {good + "parameter E normal 2 0\n", "deviation > 0"},
      {good + "parameter E lognormal 2 1\n", "factor > 1"},
      {good + "parameter E list 1 x\n", "a.study:3: expression \"x\""},
      {good + "parameter 2E list 1\n", "expected a name of letters"},
      {good + "parameter E list 1\nparameter E list 2\n", "a.study:4: the name E is taken"},
      {good + "parameter E normal 1 2\n", "a.study:3: E is sampled: expected a line \"samples COUNT\""},
      {good + "samples 4\n", "a.study:3: expected a parameter that is sampled"},
      {good + "samples 0\n", "a.study:3: expected the number of samples"},
      {good + "samples 4 sed 1\n", "expected: samples COUNT [seed NUMBER]"},
      {good + "target a group c\n", "a.study:3: the target a is there already"},
      {good + "target c point 1 2\n", "expected: target NAME group GROUP"},
      {good + "unknown E guess -1\n", "NUMBER > 0"},
      {good + "unknown E guess 1\n", "a.study: expected a line \"measured\""},
      {good + "measured m.csv deviation 1\n", "a.study: a measurement needs a line \"unknown\""},
      {good + "unknown E guess 1\nmeasured none.csv deviation 1\n", "none.csv: expected a file of measured"},
      {good + "unknown E guess 1\nparameter F list 1\nmeasured none.csv deviation 1\n", "make two studies of it"},
      {good + "tolerance 0\n", "NUMBER > 0"},
      {good + "tolerance 1\ntolerance 2\n", "a.study:4: expected one line \"tolerance\""},
      {good + "samples 1\nsamples 2\n", "a.study:4: expected one line \"samples\""},
      {good + "parameter status list 1\n", "a.study:3: the name status is taken"},
      {good + "parameter mean_x list 1\n", "a.study:3: the name mean_x is taken"},
      {good + "parameter a_ux list 1\n", "a.study:2: the column a_ux of the target is taken"},
  };
  const Folder folder;
  for (const auto& [text, expected] : refused) {
    const std::string path = folder.write("a.study", text);
    const std::string error = error_of([&] { read_study(path); });
    EXPECT_NE(error.find(expected), std::string::npos) << text << "\ngave: " << error;
  }
  EXPECT_NE(error_of([&] { read_study(folder.file("")); }).find("expected a study file"), std::string::npos);
  EXPECT_NE(error_of([&] { read_measurement(folder.file(""), true); }).find("expected a file of"), std::string::npos);
}

TEST(StudyFile, NamesTheLineOfAnExpressionThatHasNoValue) {
  const Folder folder;
  const Study study =
      read_study(folder.write("a.study", "run body.msh --young {F}\ntarget a group b\nparameter E list 1\n"));
  EXPECT_NE(error_of([&] { scene_words(study, {1.0}); }).find("a.study:1: expression \"F\""), std::string::npos);
}

/// A beam that is held at one end and pushed at the other, with these words more.
Study beam_study(const Folder& folder, const std::string& words) {
  phymul::write_pml(phymul::make_tetrahedral_block({0.06, 0.02, 0.02}, 6, 2, 2, 0.1, 1), folder.file("beam.pml"));
  return read_study(folder.write("beam.study", "run " + folder.file("beam.pml") + " --fix x0 --force x1=0,0,-0.01 " +
                                                   words + "\ntarget tip group x1\n"));
}

TEST(StudyScene, IsCutAsItsWordsSay) {
  const Folder folder;
  const auto sinks = [&](const std::string& words) {
    const Study study = beam_study(folder, words);
    const SceneResult result = SceneSolver(study).solve({});
    return result.failure.empty() ? -result.values.at(5) : 0.0;
  };
  const double whole = sinks(""), cut = sinks("--cut 0.03 0 0 1 0 0 --cut-front 0 0 0.01 0 0 -1");
  EXPECT_GT(whole, 1e-4);
  EXPECT_GT(cut, 1.2 * whole);
  const Study torn = beam_study(folder, "--cut 0.03 0 0 1 0 0 --cut-front 0 0 0.01 0 0 -1 --tear 3 0");
  EXPECT_NE(SceneSolver(torn).solve({}).failure.find("--tear: expected"), std::string::npos);
}

TEST(StudyScene, HasTheFilesOfAllScenes) {
  const Folder folder;
  folder.write("1.lml", "<loads/>");
  const Study study = beam_study(folder, folder.file("{1}.lml"));
  EXPECT_NE(error_of([&] { study_fingerprint(study, {}); }).find("expected the same files in all scenes, got "),
            std::string::npos);
  const Study missing = beam_study(folder, folder.file("none.lml"));
  EXPECT_NE(error_of([&] { SceneSolver(missing).solve({}); }).find("none.lml: this file does not exist"),
            std::string::npos);
}

TEST(StudyMeasurement, IsReadAsItWasWritten) {
  const Folder folder;
  Measurement written;
  written.point = {{0.1, 0.2, 1.0 / 3.0}, {1, 2, 3}};
  written.displacement = {{1e-3, -2e-300, 0}, {0.1 + 0.2, 0, 1}};
  write_measurement(folder.file("m.csv"), written);
  const Measurement read = read_measurement(folder.file("m.csv"), true);
  EXPECT_EQ(read.point, written.point);
  EXPECT_EQ(read.displacement, written.displacement);
  EXPECT_EQ(read_measurement(folder.write("p.csv", "x,y,z\r\n1,2,3\r\n"), false).point.size(), 1);
}

TEST(StudyMeasurement, RefusesWithFileAndLine) {
  const Folder folder;
  const std::pair<std::string, std::string> refused[] = {
      {"x,y,z\n1,2,3\n", "m.csv:1: expected the columns x,y,z,ux,uy,uz, got x,y,z"},
      {"x,y,z,ux,uy,uz\n1,2,3,4,5\n", "m.csv:2: expected 6 numbers, got 5"},
      {"x,y,z,ux,uy,uz\n\n1,2,3,4,5,six\n", "m.csv:3: expected a number, got \"six\""},
      {"x,y,z,ux,uy,uz\n1,2,3,4,5,nan\n", "m.csv:2: expected a number, got \"nan\""},
      {"x,y,z,ux,uy,uz\n", "m.csv:1: expected at least one point"}};
  for (const auto& [text, expected] : refused) {
    const std::string path = folder.write("m.csv", text);
    const std::string error = error_of([&] { read_measurement(path, true); });
    EXPECT_NE(error.find(expected), std::string::npos) << text << "\ngave: " << error;
  }
}

const std::vector<std::pair<std::vector<double>, SceneResult>> three_results{
    {{1.0 / 3.0, 2.0}, {.failure = {}, .values = {0.1, -0.0, 5e-324, 1e308}}},
    {{2.0 / 3.0, 2.0}, {.failure = "no rest shape found: 7 of 8", .values = {}}},
    {{3.0, -1e-9}, {.failure = {}, .values = {1, 2, 3, 4}}}};

void add_all(StudyJournal& journal) {
  for (const auto& [values, result] : three_results) {
    if (!journal.find(values)) journal.add(values, result);
  }
}

void expect_all(const StudyJournal& journal) {
  EXPECT_EQ(journal.size(), three_results.size());
  for (const auto& [values, result] : three_results) {
    const SceneResult* found = journal.find(values);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(found->failure, result.failure);
    EXPECT_EQ(found->values, result.values);
  }
}

TEST(StudyJournal, IsReadAsItWasWritten) {
  const Folder folder;
  add_all(*std::make_unique<StudyJournal>(folder.file("r"), 5));
  const StudyJournal again(folder.file("r"), 5);
  expect_all(again);
  EXPECT_TRUE(again.notes().empty());
}

TEST(StudyJournal, TornAtAnyByteItGoesOn) {
  const Folder folder;
  add_all(*std::make_unique<StudyJournal>(folder.file("r"), 5));
  const std::string whole = content(folder.file("r"));
  for (std::size_t size = 0; size <= whole.size(); size += 3) {
    folder.write("r", whole.substr(0, size));
    StudyJournal journal(folder.file("r"), 5);
    const auto lines = std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size), '\n');
    EXPECT_EQ(journal.size(), std::max<std::ptrdiff_t>(0, lines - 1));
    EXPECT_EQ(journal.notes().empty(), size == 0 || whole[size - 1] == '\n');
    add_all(journal);
    expect_all(journal);
    ASSERT_EQ(content(folder.file("r")), whole) << "cut after " << size;
  }
}

TEST(StudyJournal, DamagedLineIsDoneAgain) {
  const Folder folder;
  add_all(*std::make_unique<StudyJournal>(folder.file("r"), 5));
  const std::string whole = content(folder.file("r"));
  const std::size_t second = whole.find('\n') + 1;
  for (std::size_t at = second; at + 1 < whole.find('\n', second); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    folder.write("r", damaged);
    StudyJournal journal(folder.file("r"), 5);
    EXPECT_EQ(journal.size(), 2);
    ASSERT_EQ(journal.notes().size(), 1);
    EXPECT_NE(journal.notes()[0].find("r:2: this line is damaged"), std::string::npos);
    add_all(journal);
    expect_all(journal);
  }
}

TEST(StudyJournal, RefusesAnotherStudyAndOtherFiles) {
  const Folder folder;
  add_all(*std::make_unique<StudyJournal>(folder.file("r"), 5));
  const std::string before = content(folder.file("r"));
  EXPECT_NE(error_of([&] { StudyJournal(folder.file("r"), 6); }).find("r:1: these are results of another study"),
            std::string::npos);
  EXPECT_EQ(content(folder.file("r")), before);
  folder.write("diary", "Dear diary");
  EXPECT_NE(error_of([&] { StudyJournal(folder.file("diary"), 6); }).find("expected results of phymul-study"),
            std::string::npos);
  EXPECT_EQ(content(folder.file("diary")), "Dear diary");
  EXPECT_NE(error_of([&] { StudyJournal(folder.file("no/such"), 6); }).find("expected a file that can be written"),
            std::string::npos);
}

TEST(StudyJournal, IsOpenInOneProcessAtATime) {
  const Folder folder;
  const StudyJournal first(folder.file("r"), 5);
  EXPECT_NE(error_of([&] { StudyJournal(folder.file("r"), 5); }).find("another process works on this study"),
            std::string::npos);
}

TEST(StudyJournal, RefusesADevice) {
  EXPECT_NE(error_of([] { StudyJournal("/dev/zero", 5); }).find("expected an ordinary file"), std::string::npos);
}

/// A limit on the size of files stands for a full disk.
TEST(StudyJournal, SaysThatTheDiskIsFullAndGoesOnWhenItIsNot) {
  const Folder folder;
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{150, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string error = error_of([&] { add_all(*std::make_unique<StudyJournal>(folder.file("r"), 5)); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(error.find("the results cannot be written"), std::string::npos) << error;
  StudyJournal journal(folder.file("r"), 5);
  ASSERT_EQ(journal.notes().size(), 1);
  EXPECT_NE(journal.notes()[0].find("this line is torn"), std::string::npos);
  add_all(journal);
  expect_all(journal);
}

}  // namespace
