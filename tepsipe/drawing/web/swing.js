// The dummy's leg on its joint, as in tepsipe/mechanics/forward_dynamics.py, driven by the velocity of the foot:
//   J θ'' = m g r sin θ - m r cos θ y_f'' - R,   R = B θ' + K b - q (C b - D θ'),   b = θ - θ_ref,   q = b² / (b² + φ_h²)
// The momentum w = J θ' + m r cos θ v needs the velocity v of the foot only.
"use strict";

// angle (rad) and its rate (rad/s) at the samples of `velocity` (m/s), NaN after a fall; the leg stands at `start` (rad)
function swing(leg, joint, rate, velocity, start) {
  const { I, B, K, C = 0, D = 0, half = Infinity } = joint;
  const inertia = I + leg.inertia + leg.mass * leg.com ** 2;
  const p = leg.mass * leg.com;
  const share = (b) => (b * b) / (b * b + half * half);
  let bent = 0;
  for (let k = 0; k < 50; k++) bent = (p * leg.gravity * Math.sin(start) + share(bent) * C * bent) / K;
  const rest = start - bent; // on which the leg stands at its first angle
  const slope = (theta, w, v) => {
    const speed = (w - p * Math.cos(theta) * v) / inertia;
    const b = theta - rest;
    const resistance = B * speed + K * b - share(b) * (C * b - D * speed);
    return [speed, p * leg.gravity * Math.sin(theta) - resistance - p * Math.sin(theta) * speed * v];
  };
  const step = 1 / rate;
  const last = velocity.length - 1;
  const at = (k) => velocity[Math.min(Math.max(k, 0), last)];
  const angle = new Float64Array(velocity.length);
  const speed = new Float64Array(velocity.length);
  let theta = start;
  let w = p * Math.cos(start) * velocity[0];
  for (let k = 0; k <= last; k++) {
    angle[k] = theta;
    speed[k] = (w - p * Math.cos(theta) * velocity[k]) / inertia;
    if (k === last) break;
    const [v0, v2] = [velocity[k], velocity[k + 1]];
    const v1 = (9 * (v0 + v2) - at(k - 1) - at(k + 2)) / 16; // of the cubic through four samples
    const [a1, b1] = slope(theta, w, v0);
    const [a2, b2] = slope(theta + 0.5 * step * a1, w + 0.5 * step * b1, v1);
    const [a3, b3] = slope(theta + 0.5 * step * a2, w + 0.5 * step * b2, v1);
    const [a4, b4] = slope(theta + step * a3, w + step * b3, v2);
    theta += (step / 6) * (a1 + 2 * a2 + 2 * a3 + a4);
    w += (step / 6) * (b1 + 2 * b2 + 2 * b3 + b4);
    if (!(Math.abs(theta) < 0.5 * Math.PI)) { angle.fill(NaN, k + 1); speed.fill(NaN, k + 1); break; }
  }
  return { angle, speed };
}
