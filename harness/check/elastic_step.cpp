#include "harness/check/elastic_step.hpp"

namespace hdmbench {

using Bounded = BoundedElastic;
using Reads = std::vector<ElasticStep::Read>;

/// What a step with the neighbours of a site reads: of the correction its load, too.
static Reads around(ElasticField field) {
  return field == ElasticField::correction ? Reads{{field, 1}, {ElasticField::load, 0}} : Reads{{field, 1}};
}

void SteppedElasticSession::write(int level, ElasticField field, const VectorField& values) {
  take({"write", level, field, [&](ElasticSession& session) { session.write(level, field, values); },
        [&](const Bounded&, int x, int y, int z) {
          Bounded::Answer answer{};
          for (std::size_t axis = 0; axis < values.extent.axes(); ++axis) {
            answer[axis] = bounded::real(values[axis][values.extent.index(x, y, z)]);
          }
          return answer;
        },
        level});
}

void SteppedElasticSession::relax(int level, ElasticField field) {
  take({sweep_step, level, field, [=](ElasticSession& session) { session.relax(level, field); },
        [=](const Bounded& of, int x, int y, int z) { return of.relax(level, field, x, y, z); }, level,
        around(field)});
}

void SteppedElasticSession::relax_from_zero(int level) {
  take({"sweep from zero",
        level,
        ElasticField::correction,
        [=](ElasticSession& session) { session.relax_from_zero(level); },
        [=](const Bounded& of, int x, int y, int z) { return of.relax_from_zero(level, x, y, z); },
        level,
        {{ElasticField::load, 0}}});
}

void SteppedElasticSession::forces(ElasticField of, ElasticField to) {
  take({"forces",
        0,
        to,
        [=](ElasticSession& session) { session.forces(of, to); },
        [=](const Bounded& answers, int x, int y, int z) { return answers.forces(of, x, y, z); },
        0,
        {{of, 1}}});
}

void SteppedElasticSession::restrict_residual(int level, ElasticField of) {
  take({"restricted residual", level + 1, ElasticField::load,
        [=](ElasticSession& session) { session.restrict_residual(level, of); },
        [=](const Bounded& answers, int x, int y, int z) {
          return answers.restricted(
              level, x, y, z, [&](int i, int j, int k) { return answers.free_residual(level, of, i, j, k); });
        },
        level, around(of)});
}

void SteppedElasticSession::restrict_load(int level) {
  take({"restricted load",
        level + 1,
        ElasticField::load,
        [=](ElasticSession& session) { session.restrict_load(level); },
        [=](const Bounded& answers, int x, int y, int z) {
          return answers.restricted(level, x, y, z,
                                    [&](int i, int j, int k) { return answers.free_load(level, i, j, k); });
        },
        level,
        {{ElasticField::load, 0}}});
}

void SteppedElasticSession::interpolate(int level) {
  take({.name = "interpolation",
        .level = level,
        .field = ElasticField::correction,
        .take = [=](ElasticSession& session) { session.interpolate(level); },
        .answer = [=](const Bounded& of, int x, int y, int z) { return of.interpolate(level, x, y, z); },
        .at = level,
        .interpolates = true});
}

void SteppedElasticSession::correct(int level, ElasticField field) {
  take({correction_step,
        level,
        field,
        [=](ElasticSession& session) { session.correct(level, field); },
        [=](const Bounded& of, int x, int y, int z) { return of.correct(level, field, x, y, z); },
        level,
        {{field, 0}},
        true});
}

void SteppedElasticSession::solve_coarsest() {
  take({"coarsest solution", coarsest(), ElasticField::correction,
        [](ElasticSession& session) { session.solve_coarsest(); },
        [](const Bounded& of, int x, int y, int z) { return of.solve_coarsest(x, y, z); }, coarsest()});
}

void SteppedElasticSession::advance(ElasticField to, ElasticField value, float factor,
                                    ElasticField direction) {
  take({"advance",
        0,
        to,
        [=](ElasticSession& session) { session.advance(to, value, factor, direction); },
        [=](const Bounded& of, int x, int y, int z) { return of.advance(value, factor, direction, x, y, z); },
        0,
        {{value, 0}, {direction, 0}}});
}

} // namespace hdmbench
