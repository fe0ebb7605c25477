#pragma once

#include "harness/applications/detection.hpp"

namespace hdmbench {

/// Whether what was found may be a wrong label: the picture itself shows another tissue there.
struct LabelDoubt {
  int label = 0;      ///< what it looks like where it is not as labelled, most often; 0: nowhere
  double share = 0.0; ///< of the disc that was found: looks like a tissue that would explain the finding
  double usual = 0.0; ///< the same of all tissue
  [[nodiscard]] bool is_serious() const;
};

/// `source` has the gray values that the scene's labels were made from, more or less. A site counts where its
/// neighbours have its label, and looks like another one where its gray value, smoothed, is nearer to the
/// median of that one in units of the deviation of each. Only labels whose modulus is higher count where
/// stiff tissue was found, only those with a lower one where soft tissue was.
[[nodiscard]] LabelDoubt doubt_labels(const ScalarField& source, const Scene& scene, const Detection& found);

} // namespace hdmbench
