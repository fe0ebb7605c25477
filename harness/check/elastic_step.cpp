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
        [&](const Bounded&, int x, int y) {
          const std::size_t at = values.extent.index(x, y);
          return Bounded::Answer{values[0][at], values[1][at]};
        },
        level});
}

void SteppedElasticSession::relax(int level, ElasticField field) {
  take({sweep_step, level, field, [=](ElasticSession& session) { session.relax(level, field); },
        [=](const Bounded& of, int x, int y) { return of.relax(level, field, x, y); }, level, around(field)});
}

void SteppedElasticSession::relax_from_zero(int level) {
  take({"sweep from zero",
        level,
        ElasticField::correction,
        [=](ElasticSession& session) { session.relax_from_zero(level); },
        [=](const Bounded& of, int x, int y) { return of.relax_from_zero(level, x, y); },
        level,
        {{ElasticField::load, 0}}});
}

void SteppedElasticSession::forces(ElasticField of, ElasticField to) {
  take({"forces",
        0,
        to,
        [=](ElasticSession& session) { session.forces(of, to); },
        [=](const Bounded& answers, int x, int y) { return answers.forces(of, x, y); },
        0,
        {{of, 1}}});
}

void SteppedElasticSession::restrict_residual(int level, ElasticField of) {
  take({"restricted residual", level + 1, ElasticField::load,
        [=](ElasticSession& session) { session.restrict_residual(level, of); },
        [=](const Bounded& answers, int x, int y) {
          return answers.restricted(level, x, y,
                                    [&](int i, int j) { return answers.free_residual(level, of, i, j); });
        },
        level, around(of)});
}

void SteppedElasticSession::restrict_load(int level) {
  take({"restricted load",
        level + 1,
        ElasticField::load,
        [=](ElasticSession& session) { session.restrict_load(level); },
        [=](const Bounded& answers, int x, int y) {
          return answers.restricted(level, x, y,
                                    [&](int i, int j) { return answers.free_load(level, i, j); });
        },
        level,
        {{ElasticField::load, 0}}});
}

void SteppedElasticSession::interpolate(int level) {
  take({.name = "interpolation",
        .level = level,
        .field = ElasticField::correction,
        .take = [=](ElasticSession& session) { session.interpolate(level); },
        .answer = [=](const Bounded& of, int x, int y) { return of.interpolate(level, x, y); },
        .at = level,
        .interpolates = true});
}

void SteppedElasticSession::correct(int level, ElasticField field) {
  take({correction_step,
        level,
        field,
        [=](ElasticSession& session) { session.correct(level, field); },
        [=](const Bounded& of, int x, int y) { return of.correct(level, field, x, y); },
        level,
        {{field, 0}},
        true});
}

void SteppedElasticSession::solve_coarsest() {
  take({"coarsest solution", coarsest(), ElasticField::correction,
        [](ElasticSession& session) { session.solve_coarsest(); },
        [](const Bounded& of, int x, int y) { return of.solve_coarsest(x, y); }, coarsest()});
}

void SteppedElasticSession::advance(ElasticField to, ElasticField value, float factor,
                                    ElasticField direction) {
  take({"advance",
        0,
        to,
        [=](ElasticSession& session) { session.advance(to, value, factor, direction); },
        [=](const Bounded& of, int x, int y) { return of.advance(value, factor, direction, x, y); },
        0,
        {{value, 0}, {direction, 0}}});
}

} // namespace hdmbench
