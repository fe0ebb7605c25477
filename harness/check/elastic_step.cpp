#include "harness/check/elastic_step.hpp"

namespace hdmbench {

namespace {

using Bounded = BoundedElastic;

} // namespace

void SteppedElasticSession::write(int level, ElasticField field, const VectorField& values) {
  take({"write", level, field, [&](ElasticSession& session) { session.write(level, field, values); },
        [&](const Bounded&, int x, int y) {
          const std::size_t at = values.extent.index(x, y);
          return Bounded::Answer{values.x[at], values.y[at]};
        }});
}

void SteppedElasticSession::relax(int level, ElasticField field) {
  take({sweep_step, level, field, [=](ElasticSession& session) { session.relax(level, field); },
        [=](const Bounded& of, int x, int y) { return of.relax(level, field, x, y); }});
}

void SteppedElasticSession::relax_from_zero(int level) {
  take({sweep_from_zero_step, level, ElasticField::correction,
        [=](ElasticSession& session) { session.relax_from_zero(level); },
        [=](const Bounded& of, int x, int y) { return of.relax_from_zero(level, x, y); }});
}

void SteppedElasticSession::forces(ElasticField of, ElasticField to) {
  take({"forces", 0, to, [=](ElasticSession& session) { session.forces(of, to); },
        [=](const Bounded& answers, int x, int y) { return answers.forces(of, x, y); }});
}

void SteppedElasticSession::restrict_residual(int level, ElasticField of) {
  take({"restricted residual", level + 1, ElasticField::load,
        [=](ElasticSession& session) { session.restrict_residual(level, of); },
        [=](const Bounded& answers, int x, int y) {
          return answers.restricted(level, x, y,
                                    [&](int i, int j) { return answers.free_residual(level, of, i, j); });
        }});
}

void SteppedElasticSession::restrict_load(int level) {
  take({restricted_load_step, level + 1, ElasticField::load,
        [=](ElasticSession& session) { session.restrict_load(level); },
        [=](const Bounded& answers, int x, int y) {
          return answers.restricted(level, x, y,
                                    [&](int i, int j) { return answers.free_load(level, i, j); });
        }});
}

void SteppedElasticSession::interpolate(int level) {
  take({"interpolation", level, ElasticField::correction,
        [=](ElasticSession& session) { session.interpolate(level); },
        [=](const Bounded& of, int x, int y) { return of.interpolate(level, x, y); }});
}

void SteppedElasticSession::correct(int level, ElasticField field) {
  take({correction_step, level, field, [=](ElasticSession& session) { session.correct(level, field); },
        [=](const Bounded& of, int x, int y) { return of.correct(level, field, x, y); }});
}

void SteppedElasticSession::solve_coarsest() {
  take({"coarsest solution", static_cast<int>(hierarchy().levels.size()) - 1, ElasticField::correction,
        [](ElasticSession& session) { session.solve_coarsest(); },
        [](const Bounded& of, int x, int y) { return of.solve_coarsest(x, y); }});
}

void SteppedElasticSession::advance(ElasticField to, ElasticField value, float factor,
                                    ElasticField direction) {
  take({advance_step, 0, to, [=](ElasticSession& session) { session.advance(to, value, factor, direction); },
        [=](const Bounded& of, int x, int y) { return of.advance(value, factor, direction, x, y); }});
}

} // namespace hdmbench
