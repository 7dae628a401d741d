// Small SVG charts; colours come from the page's style, so that both themes use one drawing.
"use strict";

// The namespace without its address: the page names none.
const SVG = Object.assign(document.createElement("div"), {innerHTML: "<svg></svg>"}).firstChild.namespaceURI;

function el(name, attributes = {}, ...children) {
  const node = name.startsWith("svg:") ? document.createElementNS(SVG, name.slice(4)) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== null) node.setAttribute(key, value);
  }
  for (const child of children.flat(Infinity)) {
    if (child !== null && child !== undefined) node.append(child);
  }
  return node;
}

const isNumber = (x) => typeof x === "number" && Number.isFinite(x);

/** A number as people write it: `digits` significant ones, a dash for none. */
function show(x, digits = 3) {
  if (!isNumber(x)) return "–";
  if (x === 0) return "0";
  const size = Math.floor(Math.log10(Math.abs(x)));
  return Math.abs(x) >= 1e5 ? x.toExponential(1) : x.toFixed(Math.min(6, Math.max(0, digits - 1 - Math.max(size, -2))));
}

/** Round steps that divide [0, top] or [low, high] into about `count`. */
function ticks(low, high, count) {
  const span = high - low || 1;
  const raw = span / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((m) => m * power).find((s) => span / s <= count) || 10 * power;
  const list = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; ++i) list.push(+(i * step).toPrecision(12));
  return list;
}

const tip = el("div", {id: "tip"});

function hover(node, text) {
  node.addEventListener("pointermove", (event) => {
    tip.textContent = typeof text === "function" ? text(event) : text;
    tip.style.opacity = tip.textContent ? 1 : 0;
    const right = event.clientX + 16 + tip.offsetWidth > innerWidth;
    tip.style.left = (right ? event.clientX - tip.offsetWidth - 12 : event.clientX + 14) + "px";
    tip.style.top = Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 6) + "px";
  });
  node.addEventListener("pointerleave", () => (tip.style.opacity = 0));
  return node;
}

function key(color, text, shape = "line") {
  const marks = {
    line: `<path d="M1 7H21" stroke="${color}" stroke-width="2.5"/>`,
    faint: `<path d="M1 7H21" stroke="${color}" stroke-width="1.2" opacity=".55"/>`,
    dash: `<path d="M1 7H21" stroke="${color}" stroke-width="2" stroke-dasharray="5 3"/>`,
    box: `<rect x="4" y="1" width="13" height="12" rx="3" fill="${color}"/>`,
  };
  const icon = el("svg:svg", {viewBox: "0 0 22 14"});
  icon.innerHTML = marks[shape];
  return el("span", {}, icon, text);
}

const legend = (...keys) => el("div", {class: "legend"}, keys);

/**
 * Lines over a common x. series: [{points: [[x, y]..], color, name, className, step}], null y leaves a gap.
 * options: {x, y: axis names, height, xMax, yMax, log (y), diagonal, marks: [{y, text}]}
 */
function lineChart(series, options = {}) {
  const W = 560, H = options.height || 230, left = 50, right = 12, top = 24, bottom = 38;
  const all = series.flatMap((s) => s.points).filter((p) => isNumber(p[1]));
  const svg = el("svg:svg", {viewBox: `0 0 ${W} ${H}`, role: "img"});
  if (!all.length) return el("p", {class: "none"}, "nothing to draw");
  const xMax = options.xMax || Math.max(...all.map((p) => p[0])), xMin = options.xMin ?? Math.min(0, ...all.map((p) => p[0]));
  const yTop = options.yMax || Math.max(...all.map((p) => p[1]), ...(options.marks || []).map((m) => m.y)) * 1.06 || 1;
  const yTicks = ticks(0, yTop, 5), xTicks = ticks(xMin, xMax, 7);
  const yMax = options.yMax || Math.max(yTop, yTicks[yTicks.length - 1]);
  const X = (x) => left + ((x - xMin) / (xMax - xMin || 1)) * (W - left - right);
  const Y = (y) => H - bottom - (Math.min(y, yMax * 1.02) / yMax) * (H - top - bottom);
  for (const y of yTicks) {
    svg.append(el("svg:path", {class: y === 0 ? "axis base" : "axis", d: `M${left} ${Y(y)}H${W - right}`}));
    svg.append(el("svg:text", {x: left - 7, y: Y(y) + 4, "text-anchor": "end"}, String(y)));
  }
  for (const x of xTicks) svg.append(el("svg:text", {x: X(x), y: H - bottom + 17, "text-anchor": "middle"}, String(x)));
  svg.append(el("svg:text", {x: W - right, y: H - 4, "text-anchor": "end"}, options.x || ""));
  svg.append(el("svg:text", {x: (options.y || "").length > 6 ? 8 : left - 7, y: top - 12, "text-anchor": (options.y || "").length > 6 ? "start" : "end"}, options.y || ""));
  if (options.diagonal) {
    svg.append(el("svg:path", {class: "series dash", d: `M${X(0)} ${Y(0)}L${X(xMax)} ${Y(yMax)}`, stroke: "var(--muted)"}));
  }
  for (const mark of options.marks || []) {
    svg.append(el("svg:path", {class: "axis dash", d: `M${left} ${Y(mark.y)}H${W - right}`, stroke: "var(--muted)"}));
    svg.append(el("svg:text", {x: W - right, y: Y(mark.y) - 5, "text-anchor": "end"}, mark.text));
  }
  for (const s of series) {
    let d = "", last = null;
    for (const [x, y] of s.points) {
      if (isNumber(y)) d += last === null ? `M${X(x)} ${Y(y)}` : s.step ? `H${X(x)}V${Y(y)}` : `L${X(x)} ${Y(y)}`;
      last = isNumber(y) ? x : null;
    }
    svg.append(el("svg:path", {class: "series " + (s.className || ""), d, stroke: s.color}));
    if (s.dots) {
      for (const [x, y] of s.points) svg.append(el("svg:circle", {cx: X(x), cy: Y(y), r: 3.2, fill: s.color}));
    }
  }
  const rule = el("svg:path", {class: "axis base", opacity: 0});
  svg.append(rule);
  hover(svg, (event) => {
    const box = svg.getBoundingClientRect(), x = xMin + (((event.clientX - box.left) / box.width) * W - left) / (W - left - right) * (xMax - xMin);
    if (x < xMin || x > xMax) { rule.setAttribute("opacity", 0); return ""; }
    rule.setAttribute("d", `M${X(x)} ${top}V${H - bottom}`);
    rule.setAttribute("opacity", 0.6);
    const lines = series.map((s) => {
      const near = s.points.reduce((a, b) => (Math.abs(b[0] - x) < Math.abs(a[0] - x) ? b : a));
      return `${s.name}: ${show(near[1])}`;
    });
    return `${options.x || ""} ${show(x)}\n${lines.join("\n")}`;
  });
  svg.addEventListener("pointerleave", () => rule.setAttribute("opacity", 0));
  return svg;
}

/** Horizontal bars. rows: [{name, value, text, whisker, color}]; a whisker is a second, larger value of the row. */
function barChart(rows, options = {}) {
  const W = 560, rowHeight = options.rowHeight || 27, left = options.left || 110, right = options.right || 105, H = rows.length * rowHeight + 6;
  const top = options.max || Math.max(...rows.map((r) => Math.max(r.value || 0, r.whisker || 0))) || 1;
  const svg = el("svg:svg", {viewBox: `0 0 ${W} ${H}`, role: "img"});
  const X = (v) => left + (v / top) * (W - left - right);
  rows.forEach((row, i) => {
    const y = i * rowHeight + 3, middle = y + rowHeight / 2 - 2;
    const end = Math.max(X(row.value || 0), row.whisker ? X(row.whisker) : 0);
    const group = el("svg:g", {},
      el("svg:rect", {x: 0, y, width: W, height: rowHeight, fill: "transparent"}),
      el("svg:text", {class: "strong", x: left - 9, y: middle + 4, "text-anchor": "end"}, row.name),
      el("svg:path", {class: "axis base", d: `M${left} ${y - 2}V${y + rowHeight - 3}`}),
      isNumber(row.value) ? el("svg:rect", {x: left, y: middle - 7, width: Math.max(1.5, X(row.value) - left), height: 14, rx: 3,
        fill: row.color || "var(--found)"}) : null,
      row.whisker ? el("svg:path", {d: `M${X(row.value)} ${middle}H${X(row.whisker)}M${X(row.whisker)} ${middle - 4}v8`,
        stroke: row.color || "var(--found)", "stroke-width": 1.5, fill: "none"}) : null,
      el("svg:text", {x: end + 8, y: middle + 4}, row.text ?? show(row.value)));
    svg.append(row.tip ? hover(group, row.tip) : group);
  });
  return svg;
}

function tile(name, value, unit, more) {
  const has = value !== "–" && value !== null && value !== undefined;
  return el("div", {class: "tile"}, el("div", {class: "name"}, name),
    el("div", {class: has ? "value" : "value none"}, has ? value : "not yet", has && unit ? el("small", {}, unit) : null),
    el("div", {class: "more"}, more || ""));
}

function card(className, title, note, ...content) {
  return el("section", {class: "card " + className}, el("h2", {}, title), note ? el("p", {class: "note"}, note) : null, content);
}

function themeButton() {
  const button = el("button", {type: "button"}, "");
  const apply = (theme) => {
    document.documentElement.dataset.theme = theme;
    button.textContent = theme === "dark" ? "Light" : "Dark";
  };
  const wanted = new URLSearchParams(location.search).get("theme");
  apply(wanted || (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light"));
  button.addEventListener("click", () => apply(document.documentElement.dataset.theme === "dark" ? "light" : "dark"));
  return button;
}
