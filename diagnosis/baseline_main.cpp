// SPDX-License-Identifier: BSD-3-Clause
// hrp-diagnose-baseline EXPERIMENT.yaml [NAME=MODEL.yaml ...]: models side by side, judged alike on the recordings that
// nothing was fitted to. The nominal one; what anybody would do first: plain linear least squares of viscous and
// Coulomb friction and rotor inertia at every driven joint (Gautier and Khalil's inverse dynamic identification in its
// simplest form); what other programs would answer (other_tools.h); and every model whose `effects` a file states.
// Prints JSON.
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "common/base/diagnostics.h"
#include "common/base/run_main.h"
#include "common/base/version.h"
#include "diagnosis/evidence/other_tools.h"
#include "diagnosis/evidence/plain_model.h"
#include "diagnosis/measurement/torque/residual.h"
#include "diagnosis/model/nominal.h"
#include "diagnosis/simulation/windows.h"

namespace {

using namespace hrp;
using namespace hrp::diagnosis;

// An experiment whose robot has the effects that a file states: that file's text from `effects:` to the next key.
std::string read_effects(const std::string& path) {
  std::ifstream file(path);
  if (!file) refuse_input(path, "cannot be read");
  std::string text, line;
  bool inside = false;
  while (std::getline(file, line)) {
    const bool top = !line.empty() && line[0] != ' ' && line[0] != '-' && line[0] != '#';
    if (top) inside = line.rfind("effects:", 0) == 0;
    if (inside) text += line + "\n";
  }
  return text;
}

Experiment add_effects(const Experiment& e, const std::string& path) {
  const Scenario stated = parse_scenario(e.scenario.text + "\n" + read_effects(path), path);
  Experiment with = e;
  with.scenario.joint_laws = stated.joint_laws;
  with.scenario.link_laws = stated.link_laws;
  with.scenario.rotor_inertia = stated.rotor_inertia;
  return with;
}

double join(const std::vector<double>& rms) {
  double sum = 0.0, n = 0.0;
  for (double x : rms) {
    if (std::isfinite(x)) {
      sum += x * x;
      n += 1.0;
    }
  }
  return n > 0.0 ? std::sqrt(sum / n) : std::nan("");
}

// Simulated positions, by joint [rad]: over the whole of each recording from its commands, or over windows from
// efforts.
std::vector<double> calc_position_errors(const Problem& problem, const std::vector<int>& held, const Experiment& e,
                                         const Hypothesis& hypothesis) {
  if (is_effort_driven(e)) return calc_window_errors(make_plant(e, hypothesis), e, problem.smooth, held, 2).rms;
  const Score score = calc_score(problem, hypothesis, held);
  std::vector<double> rms;
  for (int j = 0; j < e.num_joints(); ++j) {
    const size_t c = static_cast<size_t>(j) * kQuantities;
    rms.push_back(score.ok ? score.rms(c) / problem.weights[c] : std::nan(""));
  }
  return rms;
}

// `data`: the same samples for all models.
nlohmann::ordered_json judge(const Problem& problem, const TorqueData& data, const Hypothesis& hypothesis) {
  const Experiment& e = *problem.experiment;
  const std::vector<double> positions = calc_position_errors(problem, get_judged(problem), e, hypothesis),
                            efforts = calc_torque_residuals(data, make_plant(e, hypothesis), !problem.validate.empty());
  const auto write = [&](const std::vector<double>& rms) {
    nlohmann::ordered_json by_joint;
    for (int j = 0; j < e.num_joints(); ++j) by_joint[e.robot.tree.joint(j).name] = rms[static_cast<size_t>(j)];
    return nlohmann::ordered_json{{"all", join(rms)}, {"joints", by_joint}};
  };
  return {{"position", write(positions)}, {"effort", write(efforts)}};
}

// Parameters by joint.
nlohmann::ordered_json write_parameters(const Experiment& e, const OtherAnswer& answer) {
  nlohmann::ordered_json joints;
  for (const Effect& effect : answer.hypothesis) {
    const EffectInfo& info = get_effect(effect.id);
    nlohmann::ordered_json& own = joints[e.robot.tree.joint(effect.place.index).name][info.name];
    for (size_t i = 0; i < effect.p.size(); ++i) own[info.parameters[i].name] = effect.p[i];
  }
  return {{"model", answer.model}, {"joints", joints}};
}

// "ticked": the parameters of MuJoCo's joints. "friction model": of the five, the one that predicts the judged
// recordings best, which favours it.
void add_other_answers(const Problem& problem, const TorqueData& data, nlohmann::ordered_json* out) {
  const std::vector<OtherAnswer> answers = fit_friction_models(problem);
  const auto write = [&](const char* name, const OtherAnswer& answer, const nlohmann::ordered_json& judged) {
    (*out)["models"][name] = judged;
    (*out)["answers"][name] = write_parameters(*problem.experiment, answer);
  };
  double least = std::numeric_limits<double>::infinity();
  for (const OtherAnswer& answer : answers) {
    const nlohmann::ordered_json judged = judge(problem, data, answer.hypothesis);
    const double error = judged["position"]["all"];  // NaN, in JSON null, where no simulation stays finite
    (*out)["friction_models"][answer.model] = error;
    if (&answer == &answers.front()) write("ticked", answer, judged);
    if (error < least) {
      least = error;
      write("friction model", answer, judged);
    }
  }
}

nlohmann::ordered_json identify(const std::string& path,
                                const std::vector<std::pair<std::string, std::string>>& models) {
  const Experiment e = load_experiment(path);
  const Problem problem = make_problem(e, 2);
  // Robots that touch the ground need more than efforts to be simulated.
  if (e.num_joints() == 0 || e.scenario.floating_base || !e.scenario.feet.empty()) return {{"joints", nullptr}};
  const std::vector<PlainDrive> fitted = fit_plain_model(problem);
  const Hypothesis hypothesis = make_plain_model(fitted);
  nlohmann::ordered_json joints;
  for (int j = 0; j < e.num_joints(); ++j) {
    const PlainDrive& x = fitted[static_cast<size_t>(j)];
    joints[e.robot.tree.joint(j).name] = {{"viscous", x.viscous}, {"coulomb", x.dry}, {"rotor_inertia", x.rotor}};
  }
  nlohmann::ordered_json out{{"joints", joints}};
  for (const auto& [name, which] : {std::pair{"train", &problem.train}, std::pair{"validate", &problem.validate}}) {
    if (which->empty()) continue;
    const Score before = calc_score(problem, {}, *which), after = calc_score(problem, hypothesis, *which);
    if (before.ok && after.ok)
      out["fit"][name] = {{"before", before.rms()}, {"after", after.rms()}};  // else it diverges
  }
  const TorqueData data = make_torque_data(e);
  out["models"]["nominal"] = judge(problem, data, {});
  out["models"]["least squares"] = judge(problem, data, hypothesis);
  add_other_answers(problem, data, &out);
  for (const auto& [name, file] : models) {
    const Experiment with = add_effects(e, file);
    out["models"][name] = judge(make_problem(with, 2), data, {});
  }
  return out;
}

// "NAME=FILE"; false where there is no name.
bool read_models(int argc, char** argv, std::vector<std::pair<std::string, std::string>>* models) {
  for (int i = 2; i < argc; ++i) {
    const std::string word = argv[i];
    const size_t at = word.find('=');
    if (at == 0 || at == std::string::npos) return false;
    models->emplace_back(word.substr(0, at), word.substr(at + 1));
  }
  return argc >= 2;
}

}  // namespace

int main(int argc, char** argv) {
  const char usage[] =
      "Usage: hrp-diagnose-baseline EXPERIMENT.yaml [NAME=MODEL.yaml ...]\n"
      "Judges models alike on recordings that nothing was fitted to: nominal, plain least squares of friction and "
      "rotor\n"
      "inertia, friction models of other programs, fitted to the positions, and the `effects` of every MODEL.yaml.\n"
      "Positions in rad by simulation (from recorded efforts over 0.5 s), efforts in N m along the recorded motion.\n"
      "Prints JSON.";
  if (hrp::answer_questions(argc, argv, "hrp-diagnose-baseline", usage)) return 0;
  std::vector<std::pair<std::string, std::string>> models;
  if (!read_models(argc, argv, &models)) {
    std::fprintf(stderr, "%s\n", usage);
    return 2;
  }
  return hrp::run_main("hrp-diagnose-baseline", [&] {
    std::printf("%s\n", identify(argv[1], models).dump(1).c_str());
    return 0;
  });
}
