// SPDX-License-Identifier: MIT
#include "run_options.h"

#include <phymul/error.h>
#include <phymul/version.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

namespace {

const std::map<std::string, phymul::Reaction> reactions{{"full", phymul::Reaction::full},
                                                        {"shared", phymul::Reaction::shared},
                                                        {"barycentric", phymul::Reaction::barycentric},
                                                        {"averaged", phymul::Reaction::averaged},
                                                        {"conservative", phymul::Reaction::conservative}};

const std::map<std::string, phymul::BaseSelection> selections{{"all", phymul::BaseSelection::all},
                                                              {"thresholded", phymul::BaseSelection::thresholded}};

/// An option that takes one of the words of a table, and names them all where it gets another.
template <class Value>
CLI::Option* add_choice(CLI::App& app, const std::string& name, Value& value,
                        const std::map<std::string, Value>& choices, const std::string& what) {
  std::string words;
  for (const auto& choice : choices) words += (words.empty() ? "" : "|") + choice.first;
  return app
      .add_option_function<std::string>(
          name,
          [name, words, &value, &choices](const std::string& word) {
            const auto choice = choices.find(word);
            if (choice == choices.end()) {
              throw CLI::ValidationError(name, "expected " + words + ", got " + word);
            }
            value = choice->second;
          },
          what)
      ->option_text(words);
}

/// CLI11's own ones tell the largest double in all its digits.
CLI::Validator number_above(bool or_zero) {
  return {[or_zero](const std::string& word) {
            double number = 0.0;
            const bool good = CLI::detail::lexical_cast(word, number) && std::isfinite(number) &&
                              (number > 0.0 || (or_zero && number == 0.0));
            return good ? std::string()
                        : "expected a number " + std::string(or_zero ? "of 0 or more" : "above 0") + ", got " + word;
          },
          or_zero ? ">= 0" : "> 0"};
}

/// That a file is missing says nothing about the options.
CLI::Validator existing_file() {
  return {[](const std::string& path) {
            if (std::filesystem::is_regular_file(path)) return std::string();
            throw phymul::Error(phymul::ErrorCode::file_access, path + ": this file does not exist", path);
          },
          "FILE"};
}

CLI::Validator positive() {
  return number_above(false);
}

CLI::Validator not_negative() {
  return number_above(true);
}

/// "GROUP=number,number": the group and its numbers, which are as many as asked for.
template <std::size_t count>
std::pair<std::string, std::array<double, count>> group_numbers(const std::string& option, const std::string& usage,
                                                                const std::string& word) {
  std::pair<std::string, std::array<double, count>> result;
  const std::size_t equals = word.rfind('=');
  std::vector<std::string> parts;
  if (equals != std::string::npos) parts = CLI::detail::split(word.substr(equals + 1), ',');
  bool good = equals != std::string::npos && equals > 0 && parts.size() == count;
  for (std::size_t k = 0; good && k < count; ++k) {
    good = CLI::detail::lexical_cast(parts[k], result.second[k]) && std::isfinite(result.second[k]);
  }
  if (!good) throw CLI::ValidationError(option, "expected " + usage + ", got " + word);
  result.first = word.substr(0, equals);
  return result;
}

/// An option that may be given several times, each time with "GROUP=number,number".
template <std::size_t count, class Take>
CLI::Option* add_of_groups(CLI::App& app, const std::string& name, const std::string& words, const std::string& example,
                           const std::string& what, Take take) {
  const auto read = [=](const std::vector<std::string>& given) {
    for (const std::string& word : given) {
      const auto [group, numbers] = group_numbers<count>(name, words + ", as in " + example, word);
      take(group, numbers);
    }
  };
  CLI::Option* option = app.add_option_function<std::vector<std::string>>(name, read, what);
  return option->option_text(words)->allow_extra_args(false);
}

void add_body_options(CLI::App& app, RunOptions& options) {
  app.add_option("body", options.body,
                 "the body: .pml, .msh (Gmsh), .vtk or .vtu; a surface: .stl, .obj, .ply, .gltf, .glb; or a labelled "
                 "image: .nii, .nii.gz, .nrrd, .nhdr")
      ->required()
      ->check(existing_file());
  app.add_option("loads", options.loads, "what acts on it: .lml")->check(existing_file());
  app.add_option("--unit", options.length_unit, "metres per length unit of the body's file [1e-3 for .pml, else 1]")
      ->check(positive());
  app.add_option("--spacing", options.spacing, "mean distance between the particles that fill a surface or image, m")
      ->check(positive());
  app.add_option("--fine-near", options.fine_balls,
                 "a finer spacing in a ball, m, which grows outside of it; may be given several times")
      ->option_text("X Y Z RADIUS SPACING")
      ->type_size(5)
      ->allow_extra_args(false)
      ->needs("--spacing");
  app.add_option("--fix", options.fixed_groups, "hold this group of particles; may be given several times")
      ->option_text("GROUP")
      ->allow_extra_args(false);
  app.add_option("--fix-near", options.fixed_balls, "hold the particles in a ball, m; may be given several times")
      ->option_text("X Y Z RADIUS")
      ->type_size(4)
      ->allow_extra_args(false);
  app.add_option("--hold-near", options.held_balls,
                 "hold the part of the surface in a ball, m; may be given several times")
      ->option_text("X Y Z RADIUS")
      ->type_size(4)
      ->allow_extra_args(false);
  add_of_groups<4>(app, "--group", "NAME=X,Y,Z,RADIUS", "tumour=0.02,0,0.01,0.008",
                   "a group more: the particles in a ball, m; may be given several times",
                   [&options](const std::string& name, const std::array<double, 4>& it) {
                     options.groups.push_back({name, it});
                   });
  add_of_groups<3>(app, "--force", "GROUP=X,Y,Z", "tip=0,0,-0.1",
                   "force on a group, N in all; may be given several times",
                   [&options](const std::string& name, const std::array<double, 3>& it) {
                     options.forces.push_back({name, {it[0], it[1], it[2]}});
                   });
  add_of_groups<3>(app, "--move", "GROUP=X,Y,Z", "tip=0,0,-0.01",
                   "imposed displacement of a group, m; may be given several times",
                   [&options](const std::string& name, const std::array<double, 3>& it) {
                     options.moves.push_back({name, {it[0], it[1], it[2]}});
                   });
  auto* cut =
      app.add_option("--cut", options.cuts,
                     "cut a body of tetrahedra or walls before the run along a plane: a point, m, and a normal; may be "
                     "given several times")
          ->option_text("X Y Z NX NY NZ")
          ->type_size(6)
          ->allow_extra_args(false);
  app.add_option("--cut-front", options.cut_front,
                 "where cuts end: a plane, behind which, against its normal, they are made [all through]")
      ->option_text("X Y Z NX NY NZ")
      ->expected(6)
      ->needs(cut);
  app.add_option_function<std::vector<double>>(
         "--tear",
         [&options](const std::vector<double>& it) {
           options.tearing = {it[0], it[1]};
         },
         "cuts go on where they are drawn: work per area, J/m^2, and the radius over which stress is averaged, m; 0: "
         "two spacings")
      ->option_text("TOUGHNESS RADIUS")
      ->expected(2)
      ->check(not_negative())
      ->needs(cut);
  app.add_option("--gravity", options.gravity, "acceleration on everything, m/s^2: x y z")->expected(3);
}

void add_elasticity_options(CLI::App& app, RunOptions& options) {
  const std::string group = "Elasticity";
  auto* young = app.add_option("--young", options.material.young, "Young's modulus, Pa")->capture_default_str();
  auto* poisson = app.add_option("--poisson", options.material.poisson, "Poisson's ratio")->capture_default_str();
  auto* density = app.add_option("--density", options.material.density, "kg/m^3")->capture_default_str();
  auto* of_groups =
      add_of_groups<2>(app, "--material", "GROUP=YOUNG,POISSON", "liver=4000,0.45",
                       "modulus (Pa) and ratio of a group, as a region of an image; may be given several times",
                       [&options](const std::string& name, const std::array<double, 2>& it) {
                         options.materials.push_back({name, {.young = it[0], .poisson = it[1]}});
                       });
  auto* from_file =
      app.add_flag("--from-file", options.from_file, "masses, stiffnesses and materials of the file alone");
  auto* reaction =
      add_choice(app, "--reaction", options.topology.reaction, reactions, "how forces are given back [conservative]");
  auto* bases = add_choice(app, "--bases", options.topology.bases, selections, "which bases [thresholded]");
  auto* springs = app.add_flag_callback(
      "--springs", [&options] { options.topology.law = phymul::Law::springs; }, "springs instead of shape memory");
  auto* volume = app.add_option("--volume-stiffness", options.topology.volume_stiffness,
                                "kappa of a volume term without a material, Pa");
  for (CLI::Option* option : {young, poisson, density, of_groups, from_file, reaction, bases, springs, volume}) {
    option->group(group);
  }
  for (CLI::Option* option : {young, poisson, density, of_groups}) from_file->excludes(option);
  for (CLI::Option* option : {reaction, bases, springs, volume}) option->needs(from_file);
}

void add_run_options(CLI::App& app, RunOptions& options) {
  const std::string group = "Run";
  for (CLI::Option* option :
       {app.add_option("--backend", options.backend, "solver by name")->capture_default_str(),
        app.add_option("--damping", options.damping_rate, "rate of loss of velocity, 1/s")
            ->capture_default_str()
            ->check(not_negative()),
        app.add_option("--threads", options.threads, "of the backend cpu; 0: as many as the body has work for")
            ->capture_default_str()
            ->check(not_negative()),
        app.add_option("--dt", options.dt, "step, s [half of the stable step]")->check(positive()),
        app.add_option("--let-go", options.let_go, "when driven particles are let go, s [their last date]")
            ->check(positive()),
        app.add_option("--max-time", options.max_time, "simulated time at most, s [20 s after the last date]")
            ->check(positive())}) {
    option->group(group);
  }
  app.add_flag("--keep", options.keep, "never let go")->group(group)->excludes("--let-go");
}

/// "3%" or "0.03".
double share_of(std::string word) {
  const bool percent = !word.empty() && word.back() == '%';
  if (percent) word.pop_back();
  double number = 0.0;
  if (!CLI::detail::lexical_cast(word, number) || !(number > 0.0) || !(number < (percent ? 100.0 : 1.0))) {
    throw CLI::ValidationError("--max-error", "expected a share as 3% or 0.03, got " + word + (percent ? "%" : ""));
  }
  return percent ? number / 100.0 : number;
}

void add_plan_options(CLI::App& app, RunOptions& options) {
  const std::string group = "Plan";
  auto* plan = app.add_flag("--plan", options.plan,
                            "find the coarsest spacing for --max-error and --rate, print it, and run nothing");
  auto* error = app.add_option_function<std::string>(
                       "--max-error", [&options](const std::string& word) { options.max_error = share_of(word); },
                       "share of the displacement, as 3% or 0.03")
                    ->option_text("SHARE");
  auto* rate = app.add_option("--rate", options.rate, "calls of 1 / rate seconds must take less than that, Hz")
                   ->capture_default_str()
                   ->check(positive());
  auto* probe =
      app.add_option("--probe-time", options.probe_time, "compare bodies in the first seconds of motion [at rest]")
          ->check(positive());
  plan->needs(error)->excludes("--spacing")->excludes("--from-file")->excludes("--dt");
  for (CLI::Option* option : {error, rate, probe}) option->needs(plan);
  for (CLI::Option* option : {plan, error, rate, probe}) option->group(group);
}

void add_output_options(CLI::App& app, RunOptions& options) {
  const std::string group = "Output";
  app.add_option("--out", options.out, "folder for results; made where it is missing")
      ->capture_default_str()
      ->group(group);
  app.add_option("--frame-interval", options.frame_interval, "simulated time between VTK frames, s; 0: none")
      ->capture_default_str()
      ->check(not_negative())
      ->group(group);
  app.add_flag_callback(
         "--no-pictures", [&options] { options.pictures = false; }, "no PNG pictures")
      ->group(group);
  app.add_flag("--profile", options.profile, "a table at the end of what the passes of the steps cost")->group(group);
  app.add_flag("--quiet", options.quiet, "say nothing on the way")->group(group);
}

}  // namespace

namespace {

void add_all_options(CLI::App& app, RunOptions& options) {
  add_body_options(app, options);
  add_elasticity_options(app, options);
  add_run_options(app, options);
  add_plan_options(app, options);
  add_output_options(app, options);
  // What is moved from the beginning has no last date at which it would be let go.
  app.callback([&options] { options.keep = options.keep || (!options.moves.empty() && !options.let_go); });
}

}  // namespace

std::optional<RunOptions> read_run_options(int argc, char** argv, int& exit_code) {
  RunOptions options;
  CLI::App app{
      "Deforms a body as its loads say, lets it go, and runs until it rests.\n"
      "The defaults suit soft tissue of some centimetres, in metres, kilograms and seconds."};
  app.name("phymul-run");
  app.set_version_flag("--version", PHYMUL_VERSION);
  app.footer(
      "Writes into the --out folder: frames/body.pvd (for ParaView), energies.csv, pulled.png, let_go.png and\n"
      "rest.png, rest.pml and rest.csv. Exit code: 0 at rest, 1 wrong input, 2 the solver failed, 3 not at rest within "
      "--max-time.");
  add_all_options(app, options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    exit_code = app.exit(error) == 0 ? 0 : 1;
    return std::nullopt;
  }
  return options;
}

RunOptions run_options_of(const std::vector<std::string>& words) {
  RunOptions options;
  CLI::App app;
  app.set_help_flag();
  add_all_options(app, options);
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // CLI11 takes them from the back
  } catch (const CLI::ParseError& error) {
    throw phymul::Error(error.what());
  }
  return options;
}

std::string quoted_word(const std::string& word) {
  const std::string plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./=,:+-";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string result = "'";
  for (const char c : word) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

std::string shortest_decimal(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}
