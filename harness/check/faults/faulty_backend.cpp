#include "harness/check/faults/faulty_backend.hpp"

#include "harness/check/compare.hpp"

namespace hdmbench::faults {

namespace {

class FaultySession : public Session {
public:
  FaultySession(std::unique_ptr<Session> sound, Fault fault, const Scene* scene)
      : sound_(std::move(sound)), fault_(std::move(fault)), scene_(scene) {}

private:
  void do_load(const Level& level) override {
    Level spoilt = level;
    if (fault_.in_level) {
      fault_.in_level(spoilt);
    }
    if (fault_.in_pyramid && scene_ != nullptr) {
      fault_.in_pyramid(spoilt, *scene_);
    }
    sound_->load(spoilt);
    begins_ = true;
  }

  void do_write(const VectorField& displacement) override {
    VectorField spoilt = displacement;
    if (begins_ && fault_.in_begin && last_read_.extent != Extent{}) {
      fault_.in_begin(spoilt, last_read_);
    }
    begins_ = false;
    if (fault_.in_write) {
      fault_.in_write(spoilt);
    }
    sound_->write(spoilt);
    before_ = spoilt;
  }

  void do_step(int /*first*/, int sweeps) override {
    const int done = fault_.in_step ? fault_.in_step(sweeps) : sweeps;
    if (fault_.in_sweep) {
      for (int i = 0; i < done; ++i) {
        spoil_sweep();
      }
    } else if (fault_.in_output && done > 0) {
      sound_->step(done - 1);
      sound_->read(before_);
      sound_->step(1);
    } else {
      sound_->step(done);
    }
  }

  void spoil_sweep() {
    sound_->read(before_);
    sound_->step(1);
    VectorField after;
    sound_->read(after);
    fault_.in_sweep(after, before_);
    changed_ = compare(before_, after).sites;
    sound_->write(after);
  }

  void do_read(VectorField& displacement) override {
    sound_->read(displacement);
    if (fault_.in_output) {
      fault_.in_output(displacement, before_);
    }
    if (fault_.in_read) {
      fault_.in_read(displacement);
    }
    last_read_ = displacement;
  }

  std::int64_t do_changed() override {
    const std::int64_t changed = fault_.in_sweep ? changed_ : sound_->changed();
    return fault_.in_changed ? fault_.in_changed(changed) : changed;
  }

protected:
  std::unique_ptr<Session> sound_;
  Fault fault_;

private:
  const Scene* scene_;
  VectorField before_;       ///< the last sweep
  VectorField last_read_;    ///< empty before the first read
  bool begins_ = false;      ///< loaded and not yet written
  std::int64_t changed_ = 0; ///< by the last sweep, where in_sweep had a hand in it
};

/// The sound session's own whole pyramids, as far as the fault lets them.
class FaultyPyramidSession final : public FaultySession {
public:
  using FaultySession::FaultySession;

private:
  void do_load_pyramid(const Pyramid& pyramid) override {
    Pyramid spoilt = pyramid;
    if (fault_.in_whole_pyramid) {
      fault_.in_whole_pyramid(spoilt);
    }
    sound_->load(spoilt);
  }
  void do_solve(const Advance& advance) override { sound_->solve(advance); }
};

/// One session for levels, another one for whole pyramids.
class TwoWaySession final : public Session {
public:
  TwoWaySession(std::unique_ptr<Session> levels, std::unique_ptr<Session> pyramids)
      : levels_(std::move(levels)), pyramids_(std::move(pyramids)), current_(levels_.get()) {}

private:
  void do_load(const Level& level) override {
    current_ = levels_.get();
    current_->load(level);
  }
  void do_load_pyramid(const Pyramid& pyramid) override {
    current_ = pyramids_.get();
    current_->load(pyramid);
  }
  void do_write(const VectorField& displacement) override { current_->write(displacement); }
  void do_step(int /*first*/, int sweeps) override { current_->step(sweeps); }
  void do_solve(const Advance& advance) override { current_->solve(advance); }
  void do_read(VectorField& displacement) override { current_->read(displacement); }
  std::int64_t do_changed() override { return current_->changed(); }

  std::unique_ptr<Session> levels_;
  std::unique_ptr<Session> pyramids_;
  Session* current_; ///< of the last load
};

bool is_on_levels(const Fault& fault) {
  return fault.in_level || fault.in_pyramid || fault.in_write || fault.in_begin || fault.in_step ||
         fault.in_sweep || fault.in_output;
}

} // namespace

std::unique_ptr<Session> FaultyBackend::do_open(std::size_t /*index*/, const SessionOptions& options) const {
  if (fault_.way == Way::active && options.work != Work::active) {
    return std::make_unique<FaultyPyramidSession>(sound_.open(options), Fault{}, scene_);
  }
  std::unique_ptr<Session> faulty;
  if (is_on_levels(fault_)) {
    faulty = std::make_unique<FaultySession>(sound_.open(options), fault_, scene_);
  } else {
    faulty = std::make_unique<FaultyPyramidSession>(sound_.open(options), fault_, scene_);
  }
  return fault_.way == Way::one_piece
             ? std::make_unique<TwoWaySession>(sound_.open(options), std::move(faulty))
             : std::move(faulty);
}

} // namespace hdmbench::faults
