// SPDX-License-Identifier: MIT
// What is drawn over the film: the hand, the force on it, and on request the motion of the whole picture.

const ARROW = 0.3, SHORTEST_ARROW = 160; // of the picture’s height, and px: for the full force; a finger hides less
const SLOWEST = 3; // px/s of a picture 352 px wide; slower cells are not drawn
const NOWHERE = Object.freeze({ x: 0, y: 0 });
const COLOURS = { hand: '#ffffff', force: '#56b4e9', edge: '#000000', field: '#e69f00' };

/** The picture in the stage, px of CSS: letterboxed as object-fit: contain. */
export function pictureIn(stage, video) {
  const { clientWidth: width, clientHeight: height } = stage;
  const shape = video.videoWidth > 0 ? video.videoWidth / video.videoHeight : width / height;
  const shown = Math.min(width, height * shape);
  return { x: (width - shown) / 2, y: (height - shown / shape) / 2, width: shown, height: shown / shape };
}

function arrow(context, x, y, dx, dy, thickness, point) {
  const length = Math.hypot(dx, dy);
  const head = Math.min(point, 0.6 * length);
  const angle = Math.atan2(dy, dx);
  const tip = side => [x + dx - head * Math.cos(angle + side), y + dy - head * Math.sin(angle + side)];
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(x + dx, y + dy);
  context.moveTo(...tip(0.5));
  context.lineTo(x + dx, y + dy);
  context.lineTo(...tip(-0.5));
  context.lineWidth = thickness;
  context.stroke();
}

function drawField(context, picture, field) {
  const cell = { width: picture.width / field.columns, height: picture.height / field.rows };
  const scale = 352 / field.width;
  for (let i = 0; i < field.x.length; ++i) {
    const x = scale * field.x[i], y = scale * field.y[i];
    const speed = Math.hypot(x, y);
    if (speed < SLOWEST || !(field.confidence[i] > 0)) continue;
    const length = cell.width * (0.35 + 0.65 * Math.atan(speed / 50) * 2 / Math.PI) / speed;
    const left = picture.x + (i % field.columns + 0.5) * cell.width - length * x / 2;
    const top = picture.y + (Math.floor(i / field.columns) + 0.5) * cell.height - length * y / 2;
    context.globalAlpha = 0.35 + 0.65 * field.confidence[i];
    for (const [colour, thickness] of [[COLOURS.edge, 3.5], [COLOURS.field, 1.5]]) {
      context.strokeStyle = colour;
      arrow(context, left, top, length * x, length * y, thickness, 6);
    }
  }
  context.globalAlpha = 1;
}

function drawHand(context, picture, place, force, blown) {
  const x = picture.x + place.x * picture.width + blown.x * picture.height;
  const y = picture.y + (place.y + blown.y) * picture.height;
  const radius = Math.max(10, 0.03 * picture.height);
  for (const [colour, thickness] of [[COLOURS.edge, 5], [COLOURS.hand, 2.5]]) {
    context.strokeStyle = colour;
    context.lineWidth = thickness;
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.stroke();
  }
  const length = Math.max(ARROW * picture.height, SHORTEST_ARROW);
  if (Math.hypot(force.x, force.y) * length < 2) return;
  for (const [colour, thickness] of [[COLOURS.edge, 8], [COLOURS.force, 5]]) {
    context.strokeStyle = colour;
    arrow(context, x, y, force.x * length, -force.y * length, thickness, 20);
  }
}

/** @returns the context of a canvas, which is empty, as large as the stage, and drawn on in px of CSS */
export function clear(canvas, stage) {
  const dots = devicePixelRatio;
  const width = Math.round(stage.clientWidth * dots), height = Math.round(stage.clientHeight * dots);
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext('2d');
  context.setTransform(dots, 0, 0, dots, 0, 0);
  context.clearRect(0, 0, width, height);
  return context;
}

/**
 * `field` may be null, and so may `place`. The force in N, y up. `blown` is how far the hand is drawn from its place,
 * in heights of the picture. `hold.draw()` draws what is held, and gives the place that the hand rides on.
 */
export function draw(canvas, stage, video, { place, force, field, blown = NOWHERE, hold }) {
  const context = clear(canvas, stage);
  context.lineCap = context.lineJoin = 'round';
  const picture = pictureIn(stage, video);
  if (field) drawField(context, picture, field);
  const ridden = hold?.draw(context, picture);
  if (ridden ?? place) drawHand(context, picture, ridden ?? place, force, ridden ? NOWHERE : blown);
}
