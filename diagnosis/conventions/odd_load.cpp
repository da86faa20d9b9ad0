// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/conventions/odd_load.h"

#include <algorithm>
#include <cmath>

#include "diagnosis/data/gaps.h"
#include "diagnosis/data/stretches.h"
#include "diagnosis/estimate/enough.h"
#include "diagnosis/estimate/gram.h"
#include "diagnosis/estimate/shares.h"
#include "diagnosis/estimate/significance.h"
#include "diagnosis/findings/odd_sizes.h"
#include "diagnosis/measurement/load_or_unit.h"

namespace hrp::diagnosis {
namespace {

constexpr long kCommon = 6;                         // v, direction, a, 1, tau, |tau| direction: the same at all times
constexpr long kFewest = kRowsPerColumn * kCommon;  // samples of a joint
constexpr long kBoth = 2 * kLoadColumns;            // a load at all times, and the same for a part

// Pieces [begin, end) of a file.
struct Part {
  size_t file = 0, begin = 0, end = 0;
};
using Parts = std::vector<Part>;

struct Fit {
  Eigen::VectorXd p, std;  // kBoth
  double nats = 0.0, left = 0.0, without = 1e-300;
};

double calc_seconds(const Experiment& e, bool train) {
  double seconds = 0.0;
  for (const Recording& r : e.recordings) seconds += r.spec.train == train ? r.duration() : 0.0;
  return seconds;
}

// True if a part of the recordings of each role is left: pieces that are too short for a recording are none.
bool keeps_enough(const Experiment& e, const OddLoad& load) {
  const Experiment rest = leave_out(e, load);
  return calc_seconds(rest, true) >= kPart * calc_seconds(e, true) &&
         calc_seconds(rest, false) >= kPart * calc_seconds(e, false);
}

class OddLoadSearch {
 public:
  explicit OddLoadSearch(const TorqueData& data) : data_(data) {
    for (size_t link = 1; link < data.experiment->robot.tree.links.size(); ++link)
      loads_.push_back({&find_term_row(&TermRow::load), static_cast<int>(link)});
    for (const TorqueRecording& r : data.recordings) {
      const size_t file = find_file(r);
      if (file == files_.size()) files_.push_back({get_name(r), HUGE_VAL, -HUGE_VAL});
      File& f = files_[file];
      f.begin = std::min(f.begin, r.begin);
      f.end = std::max(f.end, r.begin + r.step * static_cast<double>(r.q.rows()));
    }
  }

  std::optional<OddLoad> run() {
    collect();
    if (joints_.empty()) return std::nullopt;
    std::optional<OddLoad> best;
    for (size_t load = 0; load < loads_.size(); ++load) {
      const Parts parts = find_parts(load);
      const std::optional<OddLoad> odd = parts.empty() ? std::nullopt : judge(parts, load);
      if (odd && (!best || odd->share > best->share)) best = odd;
    }
    return best;
  }

 private:
  struct File {
    std::string name;
    double begin, end;  // [s]
    // At the ends of a piece something may be taken up or laid down.
    double piece() const { return (end - begin) / kFolds; }
  };

  const std::string& get_name(const TorqueRecording& r) const {
    return data_.experiment->recordings[r.index].spec.file;
  }
  size_t find_file(const TorqueRecording& r) const {
    size_t file = 0;
    while (file < files_.size() && files_[file].name != get_name(r)) ++file;
    return file;
  }
  size_t find_piece(const File& f, double time) const {
    return static_cast<size_t>(std::clamp((time - f.begin) / f.piece(), 0.0, kFolds - 1.0));
  }

  void collect() {
    std::vector<std::vector<Eigen::MatrixXd>> columns;  // by recording, by joint
    for (const TorqueRecording& r : data_.recordings) columns.push_back(calc_whole_columns(data_, r, loads_));
    for (size_t j = 0; j < data_.source.size(); ++j) {
      if (data_.source[j] == EffortSource::kRecorded) add_joint(static_cast<int>(j), columns);
    }
  }

  // Sums over the first pieces of every file, of friction, rotor and gain, and of the loads of all links.
  void add_joint(int joint, const std::vector<std::vector<Eigen::MatrixXd>>& columns) {
    const long width = kCommon + kLoadColumns * static_cast<long>(loads_.size());
    std::vector<std::vector<Gram>> until(files_.size(), std::vector<Gram>(kFolds + 1, Gram(width)));
    Eigen::VectorXd row(width);
    double n = 0.0;
    for (size_t i = 0; i < data_.recordings.size(); ++i) {
      const TorqueRecording& r = data_.recordings[i];
      const size_t f = find_file(r);
      const Eigen::VectorXd direction = data_.calc_sign(r, joint);
      for (long k = 0; k < r.kept(); ++k) {
        if (!r.use(k, joint)) continue;
        const long full = r.full_row(k);
        const double tau = r.tau(full, joint);
        row << r.v(full, joint), direction[full], r.a(full, joint), 1.0, tau, std::abs(tau) * direction[full],
            columns[i][static_cast<size_t>(joint)].row(k).transpose();
        until[f][find_piece(files_[f], r.time(k)) + 1].add_row(row, r.missing(k, joint));
        n += 1.0;
      }
    }
    if (n < static_cast<double>(kFewest)) return;
    for (std::vector<Gram>& file : until) {
      for (size_t p = 1; p < file.size(); ++p) file[p].add(file[p - 1], 1.0);
    }
    joints_.push_back(std::move(until));
    samples_ += n;
  }

  // Sums with a load at all times (the first four columns) and for these parts, once friction, rotor and gain are taken
  // out.
  Gram reduce(const std::vector<std::vector<Gram>>& joint, const Parts& parts, size_t load) const {
    Columns columns;
    for (long c = 0; c < kCommon; ++c) columns.push_back(c);
    for (long c = 0; c < kLoadColumns; ++c) columns.push_back(kCommon + kLoadColumns * static_cast<long>(load) + c);
    constexpr long kOne = kCommon + kLoadColumns;
    Gram all(kOne), part(kOne);
    for (const std::vector<Gram>& file : joint) all.add(file.back().pick(columns), 1.0);
    for (const Part& p : parts) {
      part.add(joint[p.file][p.end].pick(columns), 1.0);
      part.add(joint[p.file][p.begin].pick(columns), -1.0);
    }
    Eigen::MatrixXd cross(kCommon, kBoth + 1), own(kBoth + 1, kBoth + 1);
    cross << all.G.topRightCorner(kCommon, kLoadColumns), part.G.topRightCorner(kCommon, kLoadColumns),
        all.b.head(kCommon);
    const Eigen::MatrixXd always = all.G.bottomRightCorner(kLoadColumns, kLoadColumns),
                          then = part.G.bottomRightCorner(kLoadColumns, kLoadColumns);
    own << always, then, all.b.tail(kLoadColumns), then, then, part.b.tail(kLoadColumns),
        all.b.tail(kLoadColumns).transpose(), part.b.tail(kLoadColumns).transpose(), all.c;
    own -= cross.transpose() * all.G.topLeftCorner(kCommon, kCommon).completeOrthogonalDecomposition().solve(cross);
    Gram out(kBoth);
    out.G = own.topLeftCorner(kBoth, kBoth);
    out.b = own.col(kBoth).head(kBoth);
    out.c = own(kBoth, kBoth);
    out.n = all.n;
    return out;
  }

  // Each joint counts over what its own loads, at all times and for these parts, leave at best.
  Fit fit(const Parts& parts, size_t load) const {
    Gram sums(kBoth);
    for (const std::vector<std::vector<Gram>>& joint : joints_) {
      const Gram own = reduce(joint, parts, load);
      const double left = own.c - own.b.dot(own.G.completeOrthogonalDecomposition().solve(own.b));
      sums.add(own, own.n / std::max(1e-300, left));
    }
    Fit out;
    const auto all = sums.G.completeOrthogonalDecomposition();
    const auto common = sums.G.topLeftCorner<kLoadColumns, kLoadColumns>().completeOrthogonalDecomposition();
    out.p = all.solve(sums.b);
    out.left = std::max(1e-300, sums.c - sums.b.dot(out.p));
    out.without = std::max(1e-300, sums.c - sums.b.head<kLoadColumns>().dot(common.solve(sums.b.head<kLoadColumns>())));
    const double independent = samples_ / kPerPeriod;
    out.nats = 0.5 * independent * std::log(out.without / out.left);
    out.std = (out.left / independent * all.pseudoInverse().diagonal()).cwiseMax(0.0).cwiseSqrt();
    return out;
  }

  // The parts that one load explains best: file by file, as long as another one is worth it.
  Parts find_parts(size_t load) const {
    Parts parts;
    double nats = kLoadColumns * kOdds;  // a load has to gain more than its numbers cost
    for (bool better = true; better;) {
      better = false;
      Parts best = parts;
      for (size_t file = 0; file < files_.size(); ++file) {
        if (std::any_of(parts.begin(), parts.end(), [&](const Part& p) { return p.file == file; })) continue;
        Parts with = parts;
        with.push_back({file, 0, kFolds});
        double most = 0.0;
        improve(load, &with, &most);
        if (most > nats + kOdds && most > 0.0) {
          best = with;
          nats = most;
          better = true;
        }
      }
      parts = best;
    }
    return parts;
  }

  // Moves one end of the last part, then the other, to where the load explains most.
  void improve(size_t load, Parts* parts, double* nats) const {
    const auto try_at = [&](size_t begin, size_t end) {
      Parts other = *parts;
      other.back().begin = begin;
      other.back().end = end;
      const Fit f = fit(other, load);
      // In a part of a file it must be told beyond what is chance among its pieces.
      const double own = f.nats - (end - begin < kFolds ? std::log(static_cast<double>(2 * kFolds)) : 0.0);
      if (own > *nats && f.p[kLoadColumns] > 0.0) {
        *nats = own;
        *parts = other;
      }
    };
    try_at(0, kFolds);
    for (size_t k = 1; k < kFolds; ++k) {
      try_at(k, kFolds);
      try_at(0, k);
    }
    const Part first = parts->back();
    for (size_t k = first.begin + 1; k < first.end; ++k) {
      try_at(k, first.end);
      try_at(first.begin, k);
    }
  }

  // Odds beyond chance, and most of what is left: friction that changes with the day takes less, and follows no mass.
  std::optional<OddLoad> judge(Parts parts, size_t load) const {
    std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.file < b.file; });
    const Fit f = fit(parts, load);
    const double mass = f.p[kLoadColumns];
    if (f.nats < (kLoadColumns + 1) * kOdds || f.left > kHalf * f.without || mass < kUnlikely * f.std[kLoadColumns])
      return std::nullopt;
    // No load that it takes up: something else, and no reason to leave recordings out.
    if (!is_possible_load(data_.experiment->robot.tree, mass)) return std::nullopt;
    OddLoad odd{{},
                loads_[load].place,
                mass,
                std::hypot(f.std[kLoadColumns], calc_blur(parts) * mass),
                f.p.tail<3>() / mass,
                f.std.tail<3>() / mass,
                1.0 - f.left / f.without,
                false};
    for (const Part& p : parts) {
      const File& file = files_[p.file];
      odd.parts.push_back({file.name, p.end - p.begin == kFolds,
                           file.begin + file.piece() * static_cast<double>(p.begin),
                           file.begin + file.piece() * static_cast<double>(p.end)});
    }
    if (std::all_of(odd.parts.begin(), odd.parts.end(), [](const LoadedPart& p) { return p.whole; }) &&
        parts.size() == files_.size())
      return std::nullopt;
    odd.leave_out = keeps_enough(*data_.experiment, odd);
    return odd;
  }

  // Relative deviation of the mass, as each end within a file is told to a piece only, evenly over it.
  static double calc_blur(const Parts& parts) {
    double ends = 0.0, pieces = 0.0;
    for (const Part& p : parts) {
      ends += (p.begin > 0 ? 1.0 : 0.0) + (p.end < kFolds ? 1.0 : 0.0);
      pieces += static_cast<double>(p.end - p.begin);
    }
    return std::sqrt(ends / 12.0) / pieces;
  }

  const TorqueData& data_;
  std::vector<File> files_;
  std::vector<Term> loads_;
  std::vector<std::vector<std::vector<Gram>>> joints_;  // by joint, by file: sums of the first pieces
  double samples_ = 0.0;                                // of all joints
};

// The stretches of a recording outside of a part, with a piece of that file's to each side, in which the hand was busy.
void add_rest(const Recording& r, const LoadedPart& part, double busy, std::vector<Recording>* out) {
  const auto find = [&](double time) {
    return static_cast<size_t>(std::lower_bound(r.time.begin(), r.time.end(), time) - r.time.begin());
  };
  const size_t begin = find(part.begin - busy), end = find(part.end + busy);
  if (begin > 0 && r.time[begin - 1] - r.time[0] > kShortestPart) out->push_back(cut_recording(r, 0, begin));
  if (end < r.size() && r.time.back() - r.time[end] > kShortestPart) out->push_back(cut_recording(r, end, r.size()));
}

}  // namespace

std::optional<OddLoad> find_odd_load(const TorqueData& data) { return OddLoadSearch(data).run(); }

Experiment leave_out(const Experiment& e, const OddLoad& load) {
  Experiment out = e;
  out.recordings.clear();
  for (const Recording& r : e.recordings) {
    const auto part =
        std::find_if(load.parts.begin(), load.parts.end(), [&](const LoadedPart& p) { return p.file == r.spec.file; });
    if (part == load.parts.end())
      out.recordings.push_back(r);
    else if (!part->whole)
      add_rest(r, *part, r.duration() / kFolds, &out.recordings);
  }
  return out;
}

}  // namespace hrp::diagnosis
