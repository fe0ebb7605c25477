#include "harness/check/faults/faulty_backend.hpp"

#include "backends/cpu/cpu.hpp"
#include "backends/cpu/elastic_serial.hpp"
#include "harness/check/certificate.hpp"
#include "harness/check/compare.hpp"
#include "harness/scene/sites.hpp"

namespace hdmbench::faults {

namespace {

class FaultySession final : public Session {
public:
  FaultySession(std::unique_ptr<Session> sound, Fault fault)
      : sound_(std::move(sound)), fault_(std::move(fault)) {}

private:
  /// Something is wrong with what happens on a level or between two.
  [[nodiscard]] bool is_on_levels() const {
    return fault_.in_level || fault_.in_write || fault_.in_step || fault_.in_sweep;
  }
  /// What is wrong with what was loaded last.
  [[nodiscard]] const Fault& fault() const {
    static const Fault none;
    return fault_.way != Way::one_piece || in_one_piece_ ? fault_ : none;
  }

  void do_load(const Level& level) override {
    in_one_piece_ = in_one_piece_ && solving_;
    Level spoilt = level;
    if (fault().in_level) {
      fault().in_level(spoilt);
    }
    sound_->load(spoilt);
  }

  void do_load_pyramid(const Pyramid& pyramid) override {
    in_one_piece_ = true;
    Pyramid spoilt = pyramid;
    if (fault_.in_pyramid) {
      fault_.in_pyramid(spoilt);
    }
    if (!is_on_levels()) {
      sound_->load(spoilt);
    }
  }

  void do_solve(const Advance& advance) override {
    if (is_on_levels()) {
      solving_ = true;
      Session::do_solve(advance);
      solving_ = false;
    } else {
      sound_->solve(advance);
    }
  }

  void do_write(const VectorField& displacement) override {
    VectorField spoilt = displacement;
    if (fault().in_write) {
      fault().in_write(spoilt);
    }
    sound_->write(spoilt);
  }

  void do_step(int /*first*/, int sweeps) override {
    const int done = fault().in_step ? fault().in_step(sweeps) : sweeps;
    if (!fault().in_sweep) {
      sound_->step(done);
      return;
    }
    VectorField before;
    VectorField after;
    for (int i = 0; i < done; ++i) {
      sound_->read(before);
      sound_->step(1);
      sound_->read(after);
      fault().in_sweep(after, before);
      changed_ = compare(before, after).sites;
      sound_->write(after);
    }
  }

  void do_read(VectorField& displacement) override {
    sound_->read(displacement);
    if (fault().in_read) {
      fault().in_read(displacement);
    }
  }

  std::int64_t do_changed() override {
    const std::int64_t changed = fault().in_sweep ? changed_ : sound_->changed();
    return fault().in_changed ? fault().in_changed(changed) : changed;
  }

  std::unique_ptr<Session> sound_;
  Fault fault_;
  bool in_one_piece_ = false; ///< a pyramid was loaded last
  bool solving_ = false;      ///< level by level
  std::int64_t changed_ = 0;  ///< by the last sweep, where in_sweep had a hand in it
};

class FaultyElasticSession final : public ElasticSession {
public:
  FaultyElasticSession(std::unique_ptr<ElasticSession> sound, Fault fault)
      : sound_(std::move(sound)), fault_(std::move(fault)) {}

  void take(const MethodStep& step) override {
    if (!fault_.in_elastic_step || fault_.in_elastic_step(step, is_waited_for_)) {
      sound_->take(step);
    }
    is_waited_for_ = false;
  }
  void read(int level, ElasticField field, VectorField& values) const override {
    sound_->read(level, field, values);
    is_waited_for_ = true;
  }
  [[nodiscard]] bool has_own_laws() const override { return sound_->has_own_laws(); }
  std::optional<LeastVolume> law_forces(const LawForces& tissues, const VectorField& displacement,
                                        VectorField& force) override {
    std::optional<LeastVolume> least = sound_->law_forces(tissues, displacement, force);
    if (fault_.in_law_forces) {
      least = least ? least : tissues(displacement, force); // the fault is one of a backend that has its own
      fault_.in_law_forces(force);
    }
    return least;
  }
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override {
    if (!fault_.in_dot) {
      return sound_->dot(first, second);
    }
    VectorField a;
    VectorField b;
    sound_->read(0, first, a);
    sound_->read(0, second, b);
    return fault_.in_dot(a, b);
  }

private:
  void do_load(ElasticHierarchy& hierarchy) override {
    if (fault_.in_hierarchy) {
      fault_.in_hierarchy(hierarchy);
    }
    sound_->load(hierarchy);
  }

  std::unique_ptr<ElasticSession> sound_;
  Fault fault_;
  mutable bool is_waited_for_ = false;
};

/// Site by site in an arithmetic that takes liberties.
class RewrittenSession final : public Session {
public:
  explicit RewrittenSession(std::vector<rewritten::Rewrite> rewrites) : rewrites_(std::move(rewrites)) {}

private:
  void do_load(const Level& level) override { level_ = level; }
  void do_write(const VectorField& displacement) override { current_ = displacement; }
  void do_read(VectorField& displacement) override { displacement = current_; }
  std::int64_t do_changed() override { return changed_; }

  void do_step(int first, int sweeps) override {
    const rewritten::Replay replay(rewrites_);
    for (int number = first; number < first + sweeps; ++number) {
      const VectorField before = current_;
      for_each_site(level_.extent, [&](int x, int y, int z) {
        set_site(current_, level_.extent.index(x, y, z),
                 proofs_of(level_).replayed_answer(level_, before, number, x, y, z));
      });
      changed_ = compare(before, current_).sites;
    }
  }

  std::vector<rewritten::Rewrite> rewrites_;
  Level level_;
  VectorField current_;
  std::int64_t changed_ = 0;
};

class RewrittenElasticSession final : public ElasticSession {
public:
  explicit RewrittenElasticSession(std::vector<rewritten::Rewrite> rewrites)
      : rewrites_(std::move(rewrites)) {}

  void take(const MethodStep& step) override {
    const rewritten::Replay replay(rewrites_);
    plain_.take(step);
  }
  void read(int level, ElasticField field, VectorField& values) const override {
    plain_.read(level, field, values);
  }
  [[nodiscard]] float dot(ElasticField first, ElasticField second) const override {
    const rewritten::Replay replay(rewrites_);
    return plain_.dot(first, second);
  }

private:
  void do_load(ElasticHierarchy& hierarchy) override { plain_.load(hierarchy); }

  std::vector<rewritten::Rewrite> rewrites_;
  ElasticSerial<rewritten::real> plain_;
};

class Rewritten final : public Backend {
public:
  explicit Rewritten(std::vector<rewritten::Rewrite> rewrites) : rewrites_(std::move(rewrites)) {}

  std::string_view name() const override { return "rewritten"; }
  std::string_view description() const override { return "plain C++ by a compiler that takes liberties"; }
  std::vector<Device> devices() const override { return {cpu_device("1 thread")}; }
  bool has_elastic() const override { return true; }

private:
  std::unique_ptr<Session> do_open(std::size_t /*index*/, const SessionOptions& /*options*/) const override {
    return std::make_unique<RewrittenSession>(rewrites_);
  }
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t /*index*/,
                                                  const SessionOptions& /*options*/) const override {
    return std::make_unique<RewrittenElasticSession>(rewrites_);
  }

  std::vector<rewritten::Rewrite> rewrites_;
};

} // namespace

std::unique_ptr<Session> spoilt(std::unique_ptr<Session> sound, Fault fault) {
  return std::make_unique<FaultySession>(std::move(sound), std::move(fault));
}

std::unique_ptr<ElasticSession> spoilt(std::unique_ptr<ElasticSession> sound, Fault fault) {
  return std::make_unique<FaultyElasticSession>(std::move(sound), std::move(fault));
}

std::unique_ptr<Session> FaultyBackend::do_open(std::size_t /*index*/, const SessionOptions& options) const {
  const bool is_sound = fault_.way == Way::active && options.work != Work::active;
  return spoilt(sound_.open(options), is_sound ? Fault{} : fault_);
}

std::unique_ptr<ElasticSession> FaultyBackend::do_open_elastic(std::size_t /*index*/,
                                                               const SessionOptions& options) const {
  return spoilt(sound_.open_elastic(options), fault_);
}

std::unique_ptr<Backend> make_rewritten(std::vector<rewritten::Rewrite> rewrites) {
  return std::make_unique<Rewritten>(std::move(rewrites));
}

std::unique_ptr<Backend> make_fused() {
  return make_rewritten({rewritten::all_fused.begin(), rewritten::all_fused.end()});
}

} // namespace hdmbench::faults
