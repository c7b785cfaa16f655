// SPDX-License-Identifier: MIT
// The motion of a field under the hand, as gst-plugins/common/samples/field-sampler.cpp and region-size.cpp compute it.

const REFERENCE_WIDTH = 352; // px, the paper's frame
const REGION = 30; // px there
const SMALLEST_REGION = 12; // px

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

// Side of the region in px; doubled for each quarter of the workspace in z.
export function regionSide(width, height, z) {
  const base = Math.max(1, Math.round(width * REGION / REFERENCE_WIDTH));
  const smallest = Math.max(SMALLEST_REGION, Math.round(width * SMALLEST_REGION / REFERENCE_WIDTH));
  const largest = Math.max(smallest, Math.min(width, height) / 2);
  return clamp(base * 2 ** (2 * z), smallest, largest);
}

// The integral of the hat function max(0, 1 - |t|), the weight of a cell around its centre, from -1 to `t`.
function hatIntegral(t) {
  const within = clamp(t, -1, 1);
  return 0.5 + within - 0.5 * within * Math.abs(within);
}

// The weights of the cells along one axis: the integral of each cell's hat over a box, in cells.
function axis(place, region, cells) {
  const box = Math.sqrt(Math.max((region * cells) ** 2 - 3, 1e-6)); // the cells and the line between them have the rest
  const centre = place * cells - 0.5;
  const left = centre - box / 2, right = centre + box / 2;
  const first = clamp(Math.ceil(left - 1), 0, cells - 1);
  const end = clamp(Math.floor(right + 1), 0, cells - 1) + 1;
  const weights = new Float64Array(end - first);
  for (let i = first; i < end; ++i) weights[i - first] = hatIntegral(right - i) - hatIntegral(left - i);
  return { first, weights };
}

/** @returns {x, y, confidence} at `place` {x, y: 0..1 from the top left, z: -1..1}, px/s, y down */
export function sampleField(field, place) {
  const side = regionSide(field.width, field.height, place.z ?? 0);
  const columns = axis(place.x, side / field.width, field.columns);
  const rows = axis(place.y, side / field.height, field.rows);
  let weight = 0, confidence = 0, x = 0, y = 0;
  for (let row = 0; row < rows.weights.length; ++row) {
    const rowWeight = rows.weights[row];
    let cell = (rows.first + row) * field.columns + columns.first;
    let sumWeight = 0, sumConfidence = 0, sumX = 0, sumY = 0;
    for (const columnWeight of columns.weights) {
      const sure = columnWeight * field.confidence[cell];
      sumWeight += columnWeight;
      sumConfidence += sure;
      sumX += sure * field.x[cell];
      sumY += sure * field.y[cell];
      ++cell;
    }
    weight += rowWeight * sumWeight;
    confidence += rowWeight * sumConfidence;
    x += rowWeight * sumX;
    y += rowWeight * sumY;
  }
  if (!(confidence > 0)) return { x: 0, y: 0, confidence: 0 };
  return {
    x: Math.fround(x / confidence), y: Math.fround(y / confidence),
    confidence: Math.fround(Math.min(confidence / weight, 1)),
  };
}
