// SPDX-License-Identifier: BSD-3-Clause
#include "diagnosis/evidence/torque_values.h"

#include <algorithm>
#include <cmath>

namespace hrp::diagnosis {

TermValues calc_values(const Term& term, const Eigen::VectorXd& p, const Eigen::VectorXd& s) {
  const double size = std::max(1e-12, std::abs(p[0]));
  switch (term.kind) {
    case TermKind::kGain: return {{1.0 - p[0]}, {s[0]}};
    case TermKind::kGainOfModel: return {{1.0 / (1.0 + p[0])}, {s[0]}};
    case TermKind::kMassError: return {{1.0 + p[0]}, {s[0]}};
    case TermKind::kSpring: {  // k q - k rest
      const double rest = p[0] != 0.0 ? -p[1] / p[0] : 0.0;
      return {{p[0], rest}, {s[0], std::hypot(s[1], rest * s[0]) / size}};
    }
    case TermKind::kCogging:  // A cos(phase) sin(N q) + A sin(phase) cos(N q)
      return {{p.norm(), term.shape, std::atan2(p[1], p[0])}, {s[0], 0.1 * term.shape, s[0] / std::max(1e-12, p.norm())}};
    case TermKind::kCarried: return {{std::clamp(p[0], 0.0, 1.0)}, {s[0]}};
    case TermKind::kPayload:  // m and m p_LP
      return {{p[0], p[1] / p[0], p[2] / p[0], p[3] / p[0]}, {s[0], s[1] / size, s[2] / size, s[3] / size}};
    default: return {{p.data(), p.data() + p.size()}, {s.data(), s.data() + s.size()}};
  }
}

}  // namespace hrp::diagnosis
