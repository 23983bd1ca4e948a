const MOST_RADIUS: f32 = max(RADIUS / SPACING, 0.5);
const GREAT_RADIUS: f32 = min(RADIUS / SPACING * SIZE_MOST, MOST_RADIUS);
const GREAT_SEMI: f32 = HEIGHT * 0.5 / SPACING * HEIGHT_MOST;
const SHAPE_REACH: f32 = sqrt(GREAT_RADIUS * GREAT_RADIUS + GREAT_SEMI * GREAT_SEMI);
const MARGIN: f32 = 2e-6;

// The particle of a cell as it would be alone.
fn free_body(cell: vec3<i32>) -> Body {
    let radius: f32 = min(RADIUS / SPACING * size_of(cell), MOST_RADIUS);
    let semi: f32 = HEIGHT * 0.5 / SPACING * height_of(cell);
    return Body(axis_of(cell), radius, semi[[rounded|, min(ROUNDING * radius, semi)]]);
}
