#include "harness/judge/registration/registration_row.hpp"

#include "harness/scene/row_fields.hpp"

namespace hdmbench {

static void list_fields(Fields& fields, NamedPicture& picture) {
  fields("caption", picture.caption);
  fields("file", picture.file);
}

static void list_fields(Fields& fields, Similarity& similarity) {
  fields("mean_squares", similarity.mean_squares);
  fields("correlation", similarity.correlation);
  fields("mutual_information", similarity.mutual_information);
}

static void list_fields(Fields& fields, RegistrationRow::Iteration& iteration) {
  fields("level", iteration.level);
  fields("width", iteration.width);
  fields("height", iteration.height);
  fields("difference", iteration.difference);
  fields("outliers", iteration.outliers);
  fields("step", iteration.step);
}

void list_fields(Fields& fields, RegistrationRow& row) {
  list_fields(fields, static_cast<RegisteredScene&>(row));
  fields("spacing", row.spacing);
  fields.newer("placement", row.placement);
  fields("algorithm", row.algorithm);
  fields.if_any("conventional", row.conventional);
  fields("energy", row.energy);
  fields("backend", row.backend);
  fields("device", row.device);
  fields("seconds", row.seconds);
  fields.if_any("conventional_seconds", row.conventional_seconds);
  fields.if_any("converged", row.converged);
  fields("before", row.before);
  fields("after", row.after);
  fields("folds", row.folds);
  fields("largest_displacement", row.largest_displacement);
  fields.if_any("iterations", row.iterations);
  fields.if_any("field", row.field);
  fields.if_any("pictures", row.pictures);
  fields.if_any("warnings", row.warnings);
}

void list_fields(Fields& fields, DetectionRow& row) {
  list_fields(fields, static_cast<RegisteredScene&>(row));
  fields.newer("placement", row.placement);
  fields("backend", row.backend);
  fields("device", row.device);
  fields("seconds", row.seconds);
  fields("registration_seconds", row.registration_seconds);
  fields("region_sites", row.region_sites);
  fields("simulations", row.simulations);
  fields("as_much_by_chance", row.as_much_by_chance);
  fields("largest_by_chance", row.largest_by_chance);
  fields("noise", row.noise);
  fields("unexplained_before", row.unexplained_before);
  fields("unexplained", row.unexplained);
  fields("largest", row.largest);
  fields("x", row.x);
  fields("y", row.y);
  fields("radius", row.radius);
  fields("contrast", row.contrast);
  fields("position_deviation", row.position_deviation);
  fields("contrast_deviation", row.contrast_deviation);
  fields.newer("contrast_at_limit", row.contrast_at_limit);
  fields.newer("contrast_undetermined", row.contrast_undetermined);
  fields.if_any("looks_like", row.looks_like);
  fields.if_any("doubted", row.doubted);
  fields.if_any("modulus", row.modulus);
  fields.if_any("deviation", row.deviation);
  fields.if_any("detection", row.detection);
  fields.if_any("pictures", row.pictures);
}

} // namespace hdmbench
