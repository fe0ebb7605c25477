#pragma once

#include "backends/backend.hpp"
#include "backends/shared/elastic_session.hpp"
#include "harness/scene/scene.hpp"

#include <functional>
#include <ostream>
#include <string>

namespace hdmbench::faults {

/// Which way of computing has the mistake.
enum class Way {
  every,     ///< all
  one_piece, ///< load(Pyramid) and solve(); level by level all is well
  active,    ///< sessions opened with Work::active
};

/// A mistake that a backend could make, planted between the caller and a sound session. Each session has
/// copies of the functions of its own, so what they remember (mutable lambdas) begins anew with it.
struct Fault {
  std::string name{};
  std::string what{};                                     ///< one line for people
  std::string method = "icm";                             ///< that it concerns (harness/scene/method.hpp)
  std::function<void(Level&)> in_level{};                 ///< spoils what load() uploads
  std::function<void(Level&, const Scene&)> in_pyramid{}; ///< the same, given the scene it was sampled from
  std::function<void(VectorField&)> in_write{};           ///< spoils what write() uploads
  /// Spoils what the first write() after a load() uploads, given what the level before ended with.
  std::function<void(VectorField& first, const VectorField& coarser)> in_begin{};
  std::function<int(int)> in_step{}; ///< sweeps really done
  /// Spoils what every single sweep makes, and what the next one starts from, given what it was made of.
  std::function<void(VectorField& after, const VectorField& before)> in_sweep{};
  std::function<void(VectorField&)> in_read{}; ///< spoils what read() returns
  /// The same, given what the field was before the last sweep.
  std::function<void(VectorField& field, const VectorField& before)> in_output{};
  std::function<std::int64_t(std::int64_t)> in_changed{}; ///< spoils the count
  std::function<void(Pyramid&)> in_whole_pyramid{};       ///< spoils what load(Pyramid) uploads
  /// A session of the elastic energy with the mistake around a sound one.
  std::function<std::unique_ptr<ElasticSession>(std::unique_ptr<ElasticSession>)> in_elastic{};
  Way way = Way::every;

  friend void PrintTo(const Fault& fault, std::ostream* stream) { *stream << fault.name; }
};

/// A sound backend with a fault; called by the fault's name. A fault in what happens on a level or between
/// two is planted into a pyramid in one piece by computing that level by level; any other goes around the
/// sound session's own way.
class FaultyBackend final : public Backend {
public:
  /// `sound` and the scene, which only in_pyramid needs, must outlive it.
  FaultyBackend(const Backend& sound, Fault fault, const Scene* scene = nullptr)
      : sound_(sound), fault_(std::move(fault)), scene_(scene) {}
  std::string_view name() const override { return fault_.name; }
  std::string_view description() const override { return "planted fault"; }
  bool supports(Update update) const override { return sound_.supports(update); }
  std::vector<Device> devices() const override { return sound_.devices(); }
  bool has_elastic() const override { return sound_.has_elastic(); }

private:
  std::unique_ptr<Session> do_open(std::size_t index, const SessionOptions& options) const override;
  std::unique_ptr<ElasticSession> do_open_elastic(std::size_t /*index*/,
                                                  const SessionOptions& options) const override {
    std::unique_ptr<ElasticSession> session = sound_.open_elastic(options);
    return fault_.in_elastic ? fault_.in_elastic(std::move(session)) : std::move(session);
  }

  const Backend& sound_;
  Fault fault_;
  const Scene* scene_;
};

} // namespace hdmbench::faults
