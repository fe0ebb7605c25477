#pragma once

#include "backends/shared/cut.hpp"
#include "harness/scene/scene.hpp"
#include "kernels/data/pyramid.hpp"

#include <span>

namespace hdmbench {

/// What of a level this process has, where several share an image: whole rows, so that a sum over the image
/// goes row by row, however many they are.
struct LevelPart {
  Extent level;     ///< all of it
  Rectangle owned;  ///< every site of a level is owned by one process; without sites where others have it all
  Rectangle loaded; ///< these and a halo: what fields of this process have

  [[nodiscard]] bool is_empty() const { return owned.extent().sites() == 0; }
};

/// How a method that goes to and fro between levels gets at what other processes have of them. Fields of a
/// level have the sites that are loaded; what is wrong at the rim of a halo creeps inwards with every sweep,
/// and renew() mends it. All calls are made by all processes in the same order. Throws DeviceError where the
/// network fails.
class LevelParts {
public:
  /// Sites of the halo of a level that is cut. Twice on end, two sweeps before and two after the coarser
  /// level, take 8; the second time the residual 1 and what restriction reads beside a site 3, but by then
  /// only 6 are gone; on the finest level the residual that a cycle begins with takes 1 more. Stationary
  /// weights at what is owned depend on moduli up to 10 sites away.
  static constexpr int halo = 12;

  LevelParts() = default;
  LevelParts(const LevelParts&) = delete;
  LevelParts& operator=(const LevelParts&) = delete;
  virtual ~LevelParts() = default;

  /// Of the whole image; scene.full has what is loaded.
  [[nodiscard]] virtual Extent image(const Scene& scene) const = 0;
  /// A level of at most CoarsestSolver::most_sites is in one piece.
  [[nodiscard]] virtual LevelPart part(Extent level) const = 0;
  /// sample_level() and sample_field() of what this process loads of the image.
  [[nodiscard]] virtual Level sample(const Level& image, Extent level, Alignment alignment,
                                     Material material) const = 0;
  [[nodiscard]] virtual VectorField sample(const VectorField& image, Extent level,
                                           Alignment alignment) const = 0;
  /// Brings the halo from those who own it.
  virtual void renew(Extent level, VectorField& field) const = 0;
  virtual void renew(Extent level, DoubleField& field) const = 0;
  /// `rows`: what each process has made of the coarser level, rows_restricted() of it.
  [[nodiscard]] virtual VectorField to_coarser(Extent fine, Extent coarse, Alignment alignment,
                                               VectorField rows) const = 0;
  /// prolongate() of what is owned.
  [[nodiscard]] virtual VectorField to_finer(Extent coarse, Extent fine, Alignment alignment,
                                             const VectorField& field) const = 0;
  /// Of a number for each row of the level, those of the rows that are loaded here: their sum, row after row.
  [[nodiscard]] virtual double sum(Extent level, std::span<const double> rows) const = 0;
  /// Of a number of each process.
  [[nodiscard]] virtual double largest(double own) const = 0;

  /// sqrt(sum() / sites).
  [[nodiscard]] double root_mean(Extent level, std::span<const double> rows) const;
};

/// This process alone has the image. Lives as long as the program.
[[nodiscard]] const LevelParts& whole_image();

/// The rows of a coarser level that sample one of these.
[[nodiscard]] Rectangle rows_restricted(Extent fine, const Rectangle& owned, Extent coarse,
                                        Alignment alignment);

} // namespace hdmbench
