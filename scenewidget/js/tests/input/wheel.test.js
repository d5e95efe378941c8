import assert from "node:assert/strict";
import { test } from "node:test";
import { zoomFactor } from "../../src/input/wheel.js";

const event = { deltaY: 100, deltaMode: 0, ctrlKey: false };

test("down is away, up is nearer, lines count more than pixels, and a leap is cut short", () => {
  assert.ok(Math.abs(zoomFactor(event) - Math.exp(0.18)) < 1e-12);
  assert.ok(Math.abs(zoomFactor(event) * zoomFactor({ ...event, deltaY: -100 }) - 1) < 1e-12);
  assert.equal(zoomFactor({ ...event, deltaY: 3, deltaMode: 1 }), zoomFactor({ ...event, deltaY: 48 }));
  assert.equal(zoomFactor({ ...event, deltaY: 1e6 }), Math.exp(0.5));
});

test("the small steps of a pinch count in full", () => {
  assert.ok(zoomFactor({ ...event, deltaY: 5, ctrlKey: true }) > zoomFactor({ ...event, deltaY: 5 }));
});
