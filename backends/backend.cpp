#include "backends/backend.hpp"

#include "backends/pieces/cut_session.hpp"
#include "backends/shared/elastic_session.hpp"
#include "backends/shared/energy_programs.hpp"
#include "backends/shared/kept_arithmetic.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <span>

namespace hdmbench {

namespace energies::Hdm {
extern const EnergyPrograms programs;
}

const EnergyPrograms& programs_of(const Energy& energy) {
  return energy.programs != nullptr ? *energy.programs : energies::Hdm::programs;
}

std::string with_own_texts(std::string_view shader, const Energy& energy, const Law* law) {
  std::string text(shader);
  const auto put = [&text](std::string_view include, std::string_view own) {
    const auto at = text.find(include);
    if (at != std::string::npos) {
      text.replace(at, include.size(), own);
    }
  };
  put("#include \"energy.inc\"", programs_of(energy).text);
  if (law != nullptr) {
    put("#include \"law.inc\"", law->text);
  }
  return text;
}

bool counts_as_software(bool runs_on_cpu) {
  return runs_on_cpu && std::getenv("HDMBENCH_SOFTWARE_AS_HARDWARE") == nullptr;
}

namespace {

std::string lower_case(std::string text) {
  std::ranges::transform(text, text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

std::size_t choose(std::string_view backend, const std::vector<Device>& devices, const std::string& request) {
  if (request.empty()) {
    const auto hardware = std::ranges::find_if_not(devices, &Device::is_software);
    return hardware == devices.end() ? 0 : static_cast<std::size_t>(hardware - devices.begin());
  }
  std::size_t number = 0;
  const char* end = request.data() + request.size();
  const auto parsed = std::from_chars(request.data(), end, number);
  if (parsed.ec == std::errc{} && parsed.ptr == end && number < devices.size()) {
    return number;
  }
  const std::string wanted = lower_case(request);
  const auto found = std::ranges::find_if(devices, [&](const Device& device) {
    return lower_case(device.name).find(wanted) != std::string::npos;
  });
  if (found == devices.end()) {
    std::string list;
    for (std::size_t i = 0; i < devices.size(); ++i) {
      list += fmt::format("{}{} \"{}\"", i == 0 ? "" : ", ", i, devices[i].name);
    }
    throw DeviceError(fmt::format("{} has no device \"{}\"; it has {}", backend, request, list));
  }
  return static_cast<std::size_t>(found - devices.begin());
}

} // namespace

template <typename Call>
auto Session::on_device(const Call& call) {
  const KeptArithmetic kept(backend_);
  return backend_.empty() ? call() : with_name(backend_, call);
}

void Session::require_supported(const Level& level) const {
  if (level.update == Update::sequential && !sequential_) {
    throw DeviceError(fmt::format("{} cannot update sequentially, only scalar can", backend_));
  }
}

void Session::load(const Level& level) {
  require_supported(level);
  extent_.reset();
  pyramid_.reset();
  on_device([&] { do_load(level); });
  extent_ = level.extent;
  written_ = false;
  stepped_ = false;
  sweeps_ = 0;
}

void Session::load(const Pyramid& pyramid) {
  if (pyramid.full == nullptr || pyramid.levels.empty() ||
      pyramid.levels.back().extent != pyramid.full->extent || needs_inverse_curvature(pyramid.full->rule)) {
    throw std::logic_error("load: not a pyramid that ends with its full level, or one whose rule needs the "
                           "curvature of every level");
  }
  require_supported(*pyramid.full);
  extent_.reset();
  written_ = false;
  stepped_ = false;
  pyramid_ = pyramid;
  on_device([&] { do_load_pyramid(pyramid); });
  extent_ = pyramid.full->extent;
}

void Session::solve(const Advance& advance) {
  if (!pyramid_ || !extent_) {
    throw std::logic_error("solve: called before load(pyramid)");
  }
  written_ = false; // where this fails
  stepped_ = false;
  on_device([&] { do_solve(advance ? advance : [](double) {}); });
  written_ = true;
  stepped_ = pyramid_->levels.back().sweeps > 0;
}

void Session::do_load_pyramid(const Pyramid& /*pyramid*/) {}

void Session::do_solve(const Advance& advance) {
  VectorField field(pyramid_->levels.front().extent);
  for (const PyramidLevel& level : pyramid_->levels) {
    if (field.extent != level.extent) {
      field = prolongate(field, level.extent, pyramid_->alignment);
    }
    if (level.extent == pyramid_->full->extent && level.strengths == pyramid_->full->strengths) {
      do_load(*pyramid_->full); // no copy of what is largest
    } else {
      Level sampled = sample_level(*pyramid_->full, level.extent, pyramid_->alignment);
      sampled.strengths = level.strengths;
      do_load(sampled);
    }
    do_write(field);
    if (level.sweeps > 0) {
      do_step(0, level.sweeps);
    }
    do_read(field);
    advance(static_cast<double>(level.extent.sites()) * level.sweeps);
  }
}

void Session::write(const VectorField& displacement) {
  require_loaded("write");
  if (pyramid_) {
    throw std::logic_error("write: called after load(pyramid)");
  }
  const auto has_all_sites = [&](const std::vector<float>& of) { return of.size() == extent_->sites(); };
  if (displacement.extent != *extent_ ||
      !std::ranges::all_of(std::span(displacement.planes).first(extent_->axes()), has_all_sites)) {
    throw std::logic_error(fmt::format("write: the field is {} x {}, the level {} x {}",
                                       displacement.extent.width, displacement.extent.height, extent_->width,
                                       extent_->height));
  }
  written_ = false; // where this fails
  on_device([&] { do_write(displacement); });
  written_ = true;
  stepped_ = false;
}

void Session::step(int sweeps) {
  require_loaded("step");
  if (pyramid_) {
    throw std::logic_error("step: called after load(pyramid)");
  }
  if (!written_ || sweeps < 0) {
    throw std::logic_error(written_ ? "step: a negative number of sweeps" : "step: called before write");
  }
  if (sweeps > 0) {
    written_ = false; // where this fails
    on_device([&] { do_step(sweeps_, sweeps); });
    written_ = true;
    sweeps_ += sweeps;
    stepped_ = true;
  }
}

void Session::read(VectorField& displacement) {
  require_loaded("read");
  if (!written_) {
    throw std::logic_error("read: called before write");
  }
  if (displacement.extent != *extent_) {
    displacement = VectorField(*extent_);
  }
  on_device([&] { do_read(displacement); });
}

std::int64_t Session::changed() {
  require_loaded("changed");
  return stepped_ ? on_device([&] { return do_changed(); }) : 0;
}

void Session::require_loaded(const char* call) const {
  if (!extent_) {
    throw std::logic_error(fmt::format("{}: called before load", call));
  }
}

std::unique_ptr<Session> Backend::open(const SessionOptions& options) const {
  const auto open_one = [this, index = choose(name(), devices(), options.device), options] {
    const KeptArithmetic kept(name());
    std::unique_ptr<Session> part = do_open(index, options);
    part->sequential_ = supports(Update::sequential);
    return part;
  };
  std::unique_ptr<Session> session = std::make_unique<CutSession>(open_one);
  session->backend_ = name();
  session->sequential_ = supports(Update::sequential);
  return session;
}

Device Backend::device(const SessionOptions& options) const {
  const std::vector<Device> all = devices();
  return all[choose(name(), all, options.device)];
}

std::optional<Ceilings> Backend::ceilings(const SessionOptions& options) const {
  const KeptArithmetic kept(name());
  return with_name(name(),
                   [&] { return do_measure_ceilings(choose(name(), devices(), options.device), options); });
}

std::unique_ptr<ElasticSession> Backend::open_elastic(const SessionOptions& options) const {
  if (!has_elastic()) {
    return nullptr;
  }
  const std::size_t index = with_name(name(), [&] { return choose(name(), devices(), options.device); });
  return std::make_unique<CutElasticSession>([this, index, options] {
    const KeptArithmetic kept(name());
    return with_name(name(), [&] { return do_open_elastic(index, options); });
  });
}

std::unique_ptr<ElasticSession> Backend::do_open_elastic(std::size_t /*index*/,
                                                         const SessionOptions& /*options*/) const {
  return nullptr;
}

} // namespace hdmbench
