#include "harness/check/faults/elastic_faults.hpp"

#include "harness/scene/method.hpp"
#include "harness/scene/sites.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace hdmbench::faults {

namespace {

using Sound = std::unique_ptr<ElasticSession>;

/// Does as the sound session; mistakes are in what derives from it.
class Carried : public ElasticSession {
public:
  explicit Carried(Sound sound) : sound_(std::move(sound)) {}

  void load(const ElasticHierarchy& hierarchy) override {
    hierarchy_ = hierarchy;
    spoil(hierarchy_);
    sound_->load(hierarchy_);
  }
  void write(int level, ElasticField field, const VectorField& values) override {
    sound_->write(level, field, values);
  }
  void read(int level, ElasticField field, VectorField& values) const override {
    sound_->read(level, field, values);
  }
  void relax(int level, ElasticField field) override { sound_->relax(level, field); }
  void relax_from_zero(int level) override { sound_->relax_from_zero(level); }
  void forces(ElasticField of, ElasticField to) override { sound_->forces(of, to); }
  void restrict_residual(int level, ElasticField of) override { sound_->restrict_residual(level, of); }
  void restrict_load(int level) override { sound_->restrict_load(level); }
  void interpolate(int level) override { sound_->interpolate(level); }
  void correct(int level, ElasticField field) override { sound_->correct(level, field); }
  void solve_coarsest() override { sound_->solve_coarsest(); }
  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) override {
    sound_->advance(to, value, factor, direction);
  }
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override {
    return sound_->dot(first, second);
  }

protected:
  virtual void spoil(ElasticHierarchy& /*hierarchy*/) {}

  [[nodiscard]] ElasticSession& sound() const { return *sound_; }
  [[nodiscard]] const ElasticHierarchy& hierarchy() const { return hierarchy_; }

  /// change(field) of what was made just now.
  template <typename Change>
  void change(int level, ElasticField field, const Change& change) {
    VectorField values;
    sound_->read(level, field, values);
    change(values);
    sound_->write(level, field, values);
  }

private:
  Sound sound_;
  ElasticHierarchy hierarchy_;
};

template <typename Session>
Fault fault(std::string name, std::string what) {
  Fault result;
  result.name = std::move(name);
  result.what = std::move(what);
  result.method = elastic_conjugate_gradients;
  result.in_elastic = [](Sound sound) -> Sound { return std::make_unique<Session>(std::move(sound)); };
  return result;
}

/// A mistake in what load() uploads.
Fault in_hierarchy(std::string name, std::string what, std::function<void(ElasticHierarchy&)> spoil) {
  class Spoilt final : public Carried {
  public:
    Spoilt(Sound sound, std::function<void(ElasticHierarchy&)> spoil)
        : Carried(std::move(sound)), spoil_(std::move(spoil)) {}

  private:
    void spoil(ElasticHierarchy& hierarchy) override { spoil_(hierarchy); }
    std::function<void(ElasticHierarchy&)> spoil_;
  };
  Fault result = fault<Carried>(std::move(name), std::move(what));
  result.in_elastic = [spoil = std::move(spoil)](Sound sound) -> Sound {
    return std::make_unique<Spoilt>(std::move(sound), spoil);
  };
  return result;
}

float one_ulp_up(float value) {
  return std::nextafter(value, std::numeric_limits<float>::infinity());
}

/// The value that is in the middle of those that are not 0.
float& middle_of(std::vector<float>& values) {
  std::vector<std::size_t> set;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] != 0.0F) {
      set.push_back(i);
    }
  }
  return values.at(set.empty() ? 0 : set[set.size() / 2]);
}

ElasticLevel& first_coarse(ElasticHierarchy& hierarchy) {
  return hierarchy.levels.at(hierarchy.levels.size() > 1 ? 1 : 0);
}

std::vector<Fault> hierarchy_faults() {
  return {
      in_hierarchy("elastic-relaxation", "a sweep goes 0.62 of the way in place of 0.6",
                   [](ElasticHierarchy& hierarchy) {
                     for (ElasticLevel& level : hierarchy.levels) {
                       for (auto& values : level.response) {
                         std::ranges::transform(values, values.begin(),
                                                [](float value) { return value * (0.62F / 0.6F); });
                       }
                     }
                   }),
      in_hierarchy("elastic-response-one-ulp", "the response of one site is one unit in the last place off",
                   [](ElasticHierarchy& hierarchy) {
                     float& value = middle_of(hierarchy.levels.front().response[0]);
                     value = one_ulp_up(value);
                   }),
      in_hierarchy(
          "elastic-parent-moment", "a moment of one coarse cell lacks a quarter: one of its children",
          [](ElasticHierarchy& hierarchy) { middle_of(first_coarse(hierarchy).moments[0]) *= 0.75F; }),
      in_hierarchy("elastic-moments-swapped", "the moments along x and y are swapped",
                   [](ElasticHierarchy& hierarchy) {
                     std::swap(hierarchy.levels.front().moments[1], hierarchy.levels.front().moments[2]);
                   }),
      in_hierarchy("elastic-mask-missing", "no coarse cell knows that its basis functions are cut",
                   [](ElasticHierarchy& hierarchy) {
                     for (ElasticLevel& level : hierarchy.levels) {
                       level.masked.cells.clear();
                       std::ranges::fill(level.masked.row_begin, 0);
                     }
                   }),
      in_hierarchy("elastic-masked-entry", "one entry of the matrix of one cut cell is 0",
                   [](ElasticHierarchy& hierarchy) {
                     std::vector<MaskedCell>& cells = first_coarse(hierarchy).masked.cells;
                     for (MaskedCell& cell : cells) {
                       const auto entry = std::ranges::find_if(
                           cell.stiffness, [](float value) { return std::abs(value) > 1e-3F; });
                       if (entry != cell.stiffness.end()) {
                         *entry = 0.0F;
                         return;
                       }
                     }
                   }),
      in_hierarchy("elastic-poisson-ratio", "Poisson's ratio 0.01 too high",
                   [](ElasticHierarchy& hierarchy) { hierarchy.ratio.nu += 0.01F; }),
      in_hierarchy("elastic-coarsest-column",
                   "the inverse of the coarsest level begins with its second column",
                   [](ElasticHierarchy& hierarchy) {
                     const auto size = 2 * hierarchy.levels.back().grid.sites.sites();
                     std::ranges::rotate(hierarchy.coarsest_inverse, hierarchy.coarsest_inverse.begin() +
                                                                         static_cast<std::ptrdiff_t>(size));
                   }),
      in_hierarchy("elastic-prescribed-freed", "a prescribed component may move",
                   [](ElasticHierarchy& hierarchy) {
                     auto& values = hierarchy.levels.front().response[0];
                     const float some = middle_of(values);
                     const RingedGrid& grid = hierarchy.levels.front().grid;
                     for_each_site(grid.sites, [&](int x, int y) {
                       float& value = values[grid.index(x, y)];
                       value = value == 0.0F ? some : value;
                     });
                   }),
  };
}

class SweepLeftOut final : public Carried {
public:
  using Carried::Carried;
  void relax(int level, ElasticField field) override {
    if (level != 1) {
      sound().relax(level, field);
    }
  }
};

class FromWhatWasThere final : public Carried {
public:
  using Carried::Carried;
  void relax_from_zero(int level) override { sound().relax(level, ElasticField::correction); }
};

class StaleLoad final : public Carried {
public:
  using Carried::Carried;
  void restrict_load(int level) override {
    if (level + 2 < static_cast<int>(hierarchy().levels.size())) {
      sound().restrict_load(level);
    }
  }
};

class RestrictionAveraged final : public Carried {
public:
  using Carried::Carried;
  void restrict_residual(int level, ElasticField of) override {
    sound().restrict_residual(level, of);
    change(level + 1, ElasticField::load, [](VectorField& load) {
      for (auto* const values : {&load.x, &load.y}) {
        std::ranges::transform(*values, values->begin(), [](float value) { return 0.25F * value; });
      }
    });
  }
};

class LastColumnUncorrected final : public Carried {
public:
  using Carried::Carried;
  void correct(int level, ElasticField field) override {
    VectorField before;
    sound().read(level, field, before);
    sound().correct(level, field);
    change(level, field, [&](VectorField& after) {
      for (int y = 0; y < after.extent.height; ++y) {
        const std::size_t site = after.extent.index(after.extent.width - 1, y);
        after.x[site] = before.x[site];
        after.y[site] = before.y[site];
      }
    });
  }
};

class ForcesOnPrescribed final : public Carried {
public:
  using Carried::Carried;
  void forces(ElasticField of, ElasticField to) override {
    sound().forces(of, to);
    const auto& response = hierarchy().levels.front().response[0];
    const RingedGrid& grid = hierarchy().levels.front().grid;
    change(0, to, [&](VectorField& force) {
      for_each_site(grid.sites, [&](int x, int y) {
        const bool prescribed = response[grid.index(x, y)] == 0.0F;
        force.x[grid.sites.index(x, y)] += prescribed ? 1.0F : 0.0F;
      });
    });
  }
};

class LoadTheWrongWay final : public Carried {
public:
  using Carried::Carried;
  void advance(ElasticField to, ElasticField value, float factor, ElasticField direction) override {
    sound().advance(to, value, to == ElasticField::load ? -factor : factor, direction);
  }
};

/// Sums in double, without the last rows.
template <int missing_rows>
class SumInDouble final : public Carried {
public:
  using Carried::Carried;
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override {
    VectorField a;
    VectorField b;
    sound().read(0, first, a);
    sound().read(0, second, b);
    double sum = 0.0;
    for (std::size_t site = 0; site < a.extent.index(0, a.extent.height - missing_rows); ++site) {
      sum += static_cast<double>(a.x[site]) * b.x[site] + static_cast<double>(a.y[site]) * b.y[site];
    }
    return static_cast<float>(sum);
  }
};

/// Seen at the end only: verify reads after every step and writes nothing.
class ForgetsWhatNobodyReads final : public Carried {
public:
  using Carried::Carried;
  void correct(int level, ElasticField field) override {
    if (!read_since_) {
      ++unread_;
    }
    read_since_ = false;
    if (unread_ != 2) { // once, and only where nothing waits
      sound().correct(level, field);
    }
  }
  void read(int level, ElasticField field, VectorField& values) const override {
    read_since_ = true;
    sound().read(level, field, values);
  }

private:
  mutable bool read_since_ = false;
  int unread_ = 0;
};

} // namespace

std::vector<Fault> elastic_faults() {
  std::vector<Fault> all = hierarchy_faults();
  const std::vector<Fault> steps{
      fault<SweepLeftOut>("elastic-sweep-left-out", "no sweep on the first coarse level"),
      fault<FromWhatWasThere>("elastic-from-zero",
                              "a sweep that starts from 0 starts from the last correction"),
      fault<StaleLoad>("elastic-stale-level", "the coarsest level keeps the load of before"),
      fault<RestrictionAveraged>("elastic-restriction-weight", "a restriction takes means in place of sums"),
      fault<LastColumnUncorrected>("elastic-last-column", "the last column is never corrected"),
      fault<ForcesOnPrescribed>("elastic-forces-on-prescribed", "prescribed components feel a force"),
      fault<LoadTheWrongWay>("elastic-advance-sign", "the load of conjugate gradients goes the wrong way"),
      fault<SumInDouble<1>>("elastic-sum-without-last-row", "a sum over the image ends a row early"),
      fault<ForgetsWhatNobodyReads>("elastic-no-barrier",
                                    "a correction is lost where nobody waits for the step before"),
  };
  all.insert(all.end(), steps.begin(), steps.end());
  return all;
}

Fault elastic_sums_in_double() {
  return fault<SumInDouble<0>>("elastic-sums-in-double", "sums over the image in double precision");
}

} // namespace hdmbench::faults
