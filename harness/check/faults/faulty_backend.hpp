#pragma once

#include "backends/backend.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/check/rewritten_real.hpp"

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace hdmbench::faults {

/// Which way of computing has the mistake.
enum class Way {
  every,     ///< all
  one_piece, ///< load(Pyramid) and solve(); level by level all is well
  active,    ///< sessions opened with Work::active
};

/// A mistake that a backend could make, planted between the caller and a sound session: what each hook that
/// is set does to what passes by. Each session has copies of the functions of its own, so what they remember
/// (mutable lambdas) begins anew with it.
struct Fault {
  std::string name{};
  std::string what{};         ///< one line for people
  std::string method = "icm"; ///< that it concerns (harness/scene/method.hpp)
  std::size_t axes = 0;       ///< 3: it is one of volumes alone; 0: of images, too
  Way way = Way::every;
  bool is_control = false;                      ///< no mistake: verify has to let it through
  std::function<void(Level&)> in_level{};       ///< spoils what load() uploads
  std::function<void(Pyramid&)> in_pyramid{};   ///< spoils what load(Pyramid) uploads
  std::function<void(VectorField&)> in_write{}; ///< spoils what write() uploads
  std::function<int(int)> in_step{};            ///< sweeps really done
  /// Spoils what every single sweep makes, and what the next one starts from, given what it was made of.
  std::function<void(VectorField& after, const VectorField& before)> in_sweep{};
  std::function<void(VectorField&)> in_read{};            ///< spoils what read() returns
  std::function<std::int64_t(std::int64_t)> in_changed{}; ///< spoils the count
  /// Spoils what a session of the elastic energy loads.
  std::function<void(ElasticHierarchy&)> in_hierarchy{};
  /// Whether a step of the elastic energy is taken; `is_waited_for`: something was read since the one before.
  std::function<bool(const MethodStep&, bool is_waited_for)> in_elastic_step{};
  /// Sums first * second over the image in place of the sound session.
  std::function<float(const VectorField& first, const VectorField& second)> in_dot{};
  std::function<void(VectorField&)> in_law_forces{}; ///< spoils what ElasticSession::law_forces() makes
};

/// `sound` with the fault between it and the caller.
[[nodiscard]] std::unique_ptr<Session> spoilt(std::unique_ptr<Session> sound, Fault fault);
[[nodiscard]] std::unique_ptr<ElasticSession> spoilt(std::unique_ptr<ElasticSession> sound, Fault fault);

/// A sound backend with a fault; called by the fault's name. A fault in what happens on a level or between
/// two is planted into a pyramid in one piece by computing that level by level; any other goes around the
/// sound session's own way.
class FaultyBackend final : public Backend {
public:
  /// `sound` must outlive it.
  FaultyBackend(const Backend& sound, Fault fault) : sound_(sound), fault_(std::move(fault)) {}
  std::string_view name() const override { return fault_.name; }
  std::string_view description() const override { return "planted fault"; }
  bool supports(Update update) const override { return sound_.supports(update); }
  std::vector<Device> devices() const override { return sound_.devices(); }
  bool has_elastic() const override { return sound_.has_elastic(); }

private:
  std::unique_ptr<Session> do_open(std::size_t index, const SessionOptions& options) const override;
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t index,
                                                  const SessionOptions& options) const override;

  const Backend& sound_;
  Fault fault_;
};

/// Controls, and mistakes in what a session is given, does and hands back, on any backend; in a whole pyramid
/// in one piece, where level by level all is well; in leaving out what cannot change, whether the backend
/// leaves out anything itself: every site is a tile, so that few sweeps over small images show them, and
/// dense all is well; in the steps and sums of the elastic energy.
[[nodiscard]] std::vector<Fault> session_faults();

/// The specification as a compiler gives it that takes these liberties; one thread.
[[nodiscard]] std::unique_ptr<Backend> make_rewritten(std::vector<rewritten::Rewrite> rewrites);
/// A control, which rounding has to explain: every product is fused into the sum or difference that follows.
[[nodiscard]] std::unique_ptr<Backend> make_fused();

} // namespace hdmbench::faults
