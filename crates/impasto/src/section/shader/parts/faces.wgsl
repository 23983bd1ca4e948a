// Takes in one face of a body: how far a point is above it, its normal, and the section's.
fn widened(gap: Gap, above: f32, face: vec3<f32>, n: vec3<f32>) -> Gap {
    let slope: vec3<f32> = face - n * dot(face, n);
    let steep: f32 = length(slope);
    if (steep > 1e-6 && above > gap.outside * steep) {
        return Gap(above / steep, slope / steep);
    }
    return gap;
}
