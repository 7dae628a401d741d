// The report of one run: data is what hgg-eval --json prints, plus "scenery" (what to draw) and "title".
const data = JSON.parse(document.getElementById("data").textContent);
const {overall, trajectory, odometry, geometry, retrieval, loops, cost, scenery} = data;
const percent = (x) => (isNumber(x) ? (100 * x).toFixed(x < 0.0995 || x > 0.995 ? 1 : 0).replace(/\.0$/, "") + " %" : "–");

/** What a ghost comes from, in words. */
const CAUSES = {second: "second node or piece of a thing", mover: "left by something that moves", gone: "of a thing taken away",
  surface: "on a surface of another class", nothing: "at nothing"};
const causesOf = (counts) => Object.entries(counts || {}).filter(([, n]) => n).map(([cause, n]) => `${n} ${CAUSES[cause]}`).join(", ");

function tiles() {
  const p = overall.position_error, c = overall.calibration;
  const list = [
    tile("Objects, F1", show(overall.f1), "", `precision ${show(overall.precision)}, recall ${show(overall.recall)}`),
    tile("Ghosts", String(overall.ghosts.length), "", causesOf(overall.ghost_causes) || "none"),
    tile("Twins", String(overall.twins), "", "pairs of one class within 0.5 m that are one true thing"),
    tile("Position error", show(p.mean), "m", `median ${show(p.median)}, worst ${show(p.max)}`),
    tile("Extent error", show(overall.extent_error.mean), "m", "2-Wasserstein to the true Gaussian"),
    tile("Calibration", show(c.mean_over_3), "× honest", `${percent(c.inside_90)} inside the 90 % region`),
    tile("Trajectory, ATE", trajectory ? show(trajectory.ate_rmse) : null, "m",
      trajectory ? (odometry ? `odometry ${show(odometry.ate_rmse)} m` : `${trajectory.pairs} poses`) : "give --trajectory"),
    tile("Geometry, Chamfer", geometry ? show(geometry.chamfer) : null, "m",
      geometry ? `map accuracy ${show(geometry.accuracy)} m` : "the truth has no cloud.ply"),
    tile("Retrieval, R@1", retrieval ? show(retrieval.r1) : null, "", retrieval ? `R@3 ${show(retrieval.r3)}, ${retrieval.queries} queries` : "give --answers"),
  ];
  if (loops) {
    list.push(tile("Loops accepted", String(loops.accepted), "", `${loops.false} false of ${loops.checked} checked; ${loops.asked} asked; ` +
      `${loops.revisits_closed} of ${loops.revisits} revisits closed` + (loops.checked ? `; worst ${show(loops.worst_m)} m` : "")));
  }
  if (cost) {
    list.push(tile("Frame time", show(cost.frame_ms.p50), "ms", `99 %: ${show(cost.frame_ms.p99)} ms, ${cost.frames} frames`));
    list.push(tile("Map", show(cost.map_mb), "MB", `process ${show(cost.peak_rss_mb)} MB at most`));
  }
  return el("div", {class: "tiles"}, list);
}

// ---- the map from above ----------------------------------------------------------------------------------------------

/** Two-sigma ellipse of the horizontal covariance [xx, xy, yy]. */
function ellipseOf([xx, xy, yy]) {
  const half = (xx + yy) / 2, root = Math.hypot((xx - yy) / 2, xy);
  return {rx: 2 * Math.sqrt(Math.max(half + root, 1e-4)), ry: 2 * Math.sqrt(Math.max(half - root, 1e-4)),
    angle: (Math.atan2(2 * xy, xx - yy) / 2) * (180 / Math.PI)};
}

function ellipse(object, attributes) {
  const e = ellipseOf(object.cov), [x, y] = object.mean;
  return el("svg:ellipse", {rx: e.rx, ry: e.ry, transform: `translate(${x} ${y}) rotate(${e.angle})`,
    "vector-effect": "non-scaling-stroke", ...attributes});
}

const polyline = (points, attributes) => el("svg:path", {d: points.map((p, i) => (i ? "L" : "M") + p[0] + " " + p[1]).join(""),
  fill: "none", "vector-effect": "non-scaling-stroke", "stroke-linejoin": "round", ...attributes});

function wallLayer() {
  const {cell, xy} = scenery.walls, s = cell * 0.92;
  let d = "";
  for (let i = 0; i < xy.length; i += 2) d += `M${(xy[i] * cell).toFixed(2)} ${(xy[i + 1] * cell).toFixed(2)}h${s}v${s}h${-s}z`;
  return el("svg:g", {}, el("svg:path", {d, fill: "var(--wall)"}));
}

/** Marks keep their size on the screen: see zoomTo(). */
const mark = (object, d, attributes) => el("svg:g", {class: "mark", "data-x": object.mean[0], "data-y": object.mean[1]},
  el("svg:path", {d, ...attributes}));

const where = (o) => `${show(o.mean[0])}, ${show(o.mean[1])}, ${show(o.mean[2])} m`;

function objectLayers() {
  const found = el("svg:g"), missed = el("svg:g"), ghosts = el("svg:g"), truth = el("svg:g"), moving = el("svg:g");
  const byId = new Map(scenery.truth.map((t) => [t.id, t]));
  for (const t of scenery.truth) {
    const outline = ellipse(t, {fill: "transparent", stroke: t.state === "moving" ? "var(--moving)" : "var(--truth)", "stroke-width": 1});
    const text = `true ${t.name} ${t.id}: ${t.state}\n${where(t)}\n${t.points} points in ${t.frames} frames`;
    if (t.state === "moving") {
      outline.setAttribute("stroke-dasharray", "2 3");
      moving.append(hover(outline, text));
    } else if (t.state === "missed") {
      missed.append(hover(el("svg:g", {}, ellipse(t, {fill: "var(--missed)", "fill-opacity": 0.25, stroke: "var(--missed)", "stroke-width": 2,
        "stroke-dasharray": "5 3"}), mark(t, "M-5-5L5 5M-5 5L5-5", {stroke: "var(--missed)", "stroke-width": 2.4})), text));
    } else {
      truth.append(hover(outline, text));
    }
  }
  for (const p of scenery.predictions) {
    const text = `${p.name}, node ${p.id}: ${p.state}${p.cause ? `, ${CAUSES[p.cause]}` : ""}\n${where(p)}`;
    if (p.state === "found") {
      const t = byId.get(p.truth);
      found.append(hover(el("svg:g", {}, ellipse(p, {fill: "var(--found)", "fill-opacity": 0.3, stroke: "var(--found)", "stroke-width": 1.6}),
        t ? polyline([p.mean, t.mean], {stroke: "var(--found)", "stroke-width": 2}) : null,
        mark(p, "M0-2.6A2.6 2.6 0 1 1-.01-2.6Z", {fill: "var(--found)"})),
        `${text}\n${show(p.distance)} m off, extent ${show(p.extent_error)} m off`));
    } else {
      const layer = p.state === "ghost" ? ghosts : moving, color = p.state === "ghost" ? "var(--ghost)" : "var(--moving)";
      layer.append(hover(el("svg:g", {}, ellipse(p, {fill: color, "fill-opacity": 0.2, stroke: color, "stroke-width": 1.4}),
        mark(p, "M0-6.5L6.5 0L0 6.5L-6.5 0Z", {stroke: color, "stroke-width": 2, fill: "var(--page)", "fill-opacity": 0.6})), text));
    }
  }
  return {truth, moving, found, missed, ghosts};
}

function pathLayers() {
  const lines = scenery.paths, layers = {};
  const style = {true: ["var(--truth)", 1.4, "5 4"], corrected: ["var(--corrected)", 2.4], odometry: ["var(--odometry)", 1.8]};
  for (const name of ["odometry", "corrected", "true"]) {
    if (!lines[name]) continue;
    const [stroke, width, dash] = style[name];
    layers[name] = el("svg:g", {}, polyline(lines[name], {stroke, "stroke-width": width, "stroke-dasharray": dash}));
  }
  return layers;
}

/** Low and high quantile of what is to be seen, so that one stray ghost does not shrink the rest. */
function extentOf() {
  const points = [...scenery.truth, ...scenery.predictions].map((o) => o.mean).concat(...Object.values(scenery.paths));
  const range = (k) => {
    const v = points.map((p) => p[k]).sort((a, b) => a - b), at = (q) => v[Math.min(v.length - 1, Math.floor(q * v.length))];
    return v.length ? [at(0.002) - 3, at(0.998) + 3] : [-10, 10];
  };
  return {x: range(0), y: range(1)};
}

function mapCard() {
  const extent = extentOf(), width = extent.x[1] - extent.x[0], height = extent.y[1] - extent.y[0];
  const W = 1180, H = Math.round(Math.min(720, Math.max(360, (W * height) / width)));
  const world = el("svg:g"), scale = el("svg:g");
  const svg = el("svg:svg", {id: "map", viewBox: `0 0 ${W} ${H}`}, world, scale);
  const layers = {walls: wallLayer(), ...pathLayers(), ...objectLayers()};
  for (const name of ["walls", "odometry", "corrected", "true", "moving", "found", "truth", "missed", "ghosts"]) {
    if (layers[name]) world.append(layers[name]);
  }
  let view = {};
  const zoomTo = (next) => {
    view = next;
    world.setAttribute("transform", `translate(${W / 2 - view.x * view.s} ${H / 2 + view.y * view.s}) scale(${view.s} ${-view.s})`);
    for (const m of world.querySelectorAll(".mark")) {
      m.setAttribute("transform", `translate(${m.dataset.x} ${m.dataset.y}) scale(${1 / view.s})`);
    }
    const metres = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].find((m) => m * view.s > 70) || 2000;
    scale.replaceChildren(el("svg:path", {d: `M20 ${H - 26}v6h${metres * view.s}v-6`, fill: "none", stroke: "var(--muted)", "stroke-width": 1.5}),
      el("svg:text", {x: 26, y: H - 28}, `${metres} m`));
  };
  const fit = () => zoomTo({x: (extent.x[0] + extent.x[1]) / 2, y: (extent.y[0] + extent.y[1]) / 2, s: Math.min(W / width, H / height)});
  fit();
  const toSvg = (event) => {
    const box = svg.getBoundingClientRect();
    return [((event.clientX - box.left) / box.width) * W, ((event.clientY - box.top) / box.height) * H];
  };
  svg.addEventListener("wheel", (event) => {
    event.preventDefault();
    const [px, py] = toSvg(event), s = view.s * Math.exp(-event.deltaY * 0.0015);
    const x = view.x + (px - W / 2) / view.s, y = view.y - (py - H / 2) / view.s;
    zoomTo({x: x - (px - W / 2) / s, y: y + (py - H / 2) / s, s});
  }, {passive: false});
  let grip = null;
  svg.addEventListener("pointerdown", (event) => { grip = toSvg(event); svg.setPointerCapture(event.pointerId); });
  svg.addEventListener("pointerup", () => (grip = null));
  svg.addEventListener("pointermove", (event) => {
    if (!grip) return;
    const at = toSvg(event);
    zoomTo({x: view.x - (at[0] - grip[0]) / view.s, y: view.y + (at[1] - grip[1]) / view.s, s: view.s});
    grip = at;
  });
  svg.addEventListener("dblclick", fit);
  const counts = {found: overall.true_positives, missed: overall.missed.length, ghosts: overall.ghosts.length};
  const names = {
    truth: ["true objects", "var(--truth)", "faint"], found: [`found (${counts.found})`, "var(--found)", "box"],
    missed: [`missed (${counts.missed})`, "var(--missed)", "box"], ghosts: [`ghosts (${counts.ghosts})`, "var(--ghost)", "box"],
    moving: ["moving, set aside", "var(--moving)", "box"], true: ["true path", "var(--truth)", "dash"],
    corrected: ["corrected path", "var(--corrected)", "line"], odometry: ["odometry from the start", "var(--odometry)", "line"],
    walls: ["walls and other stuff", "var(--wall)", "box"]};
  const toggles = Object.entries(names).filter(([name]) => layers[name] && layers[name].childNodes.length).map(([name, [text, color, shape]]) => {
    const box = el("input", {type: "checkbox", checked: ""}), label = el("label", {}, box, ...key(color, text, shape).childNodes);
    box.addEventListener("change", () => {
      layers[name].style.display = box.checked ? "" : "none";
      label.className = box.checked ? "" : "off";
    });
    return label;
  });
  window.showAt = (x, y) => { zoomTo({x, y, s: Math.max(view.s, 40)}); svg.scrollIntoView({behavior: "smooth", block: "center"}); };
  return card("wide", "The map from above", "Two-sigma ellipses. Drag to move, wheel to zoom, double-click to see all, click names to hide.",
    el("div", {class: "legend"}, toggles), svg);
}

// ---- numbers ---------------------------------------------------------------------------------------------------------

function countBar(s, top) {
  const W = 300, X = (n) => (n / top) * W, part = (from, n, color) => el("svg:rect", {x: X(from), y: 2, width: Math.max(0, X(n) - (n ? 1 : 0)),
    height: 12, rx: 2, fill: color});
  const missed = s.missed.length, ghosts = s.ghosts.length, found = s.true_positives;
  return hover(el("svg:svg", {viewBox: `0 0 ${W} 16`, preserveAspectRatio: "none", height: 16}, part(0, found, "var(--found)"),
    part(found, missed, "var(--missed)"), part(found + missed, ghosts, "var(--ghost)")), `${found} found, ${missed} missed, ${ghosts} ghosts`);
}

function classCard() {
  const rows = [...data.classes].sort((a, b) => b.truth - a.truth || b.predicted - a.predicted);
  const top = Math.max(1, ...rows.map((s) => s.true_positives + s.missed.length + s.ghosts.length));
  const line = (name, s, bar, className) => el("tr", {class: className}, el("td", {}, name), el("td", {class: "bar"}, bar),
    [s.truth, s.true_positives, s.missed.length, s.ghosts.length].map((n) => el("td", {}, String(n))),
    [s.precision, s.recall, s.f1, s.position_error.mean, s.extent_error.mean].map((x) => el("td", {}, isNumber(x) ? x.toFixed(2) : "–")));
  const head = ["class", "", "true", "found", "missed", "ghosts", "precision", "recall", "F1", "position, m", "extent, m"];
  return card("wide", "Per class", `Things of the same class within ${data.radius} m, closest pairs first.`,
    legend(key("var(--found)", "found", "box"), key("var(--missed)", "missed", "box"), key("var(--ghost)", "ghost", "box")),
    el("div", {class: "scroll"}, el("table", {}, el("tr", {}, head.map((h) => el("th", {}, h))),
      rows.map((s) => line(s.name, s, countBar(s, top))), line("all", overall, "", "sum"))));
}

function errorCard() {
  const cumulative = (values) => {
    const sorted = [...values].sort((a, b) => a - b);
    return [[0, 0], ...sorted.map((v, i) => [v, (100 * (i + 1)) / sorted.length])];
  };
  const position = cumulative(overall.matches.map((m) => m.distance)), extent = cumulative(overall.matches.map((m) => m.extent_error));
  const xMax = Math.max(0.05, ...[position, extent].map((c) => (c.find((p) => p[1] >= 97) || [0])[0] * 1.2));
  const cut = (c) => [...c.filter((p) => p[0] <= xMax), [xMax, (c.filter((p) => p[0] <= xMax).pop() || [0, 0])[1]]];
  return card("", "How far off the found objects are", "Share of found objects with at most this error.",
    legend(key("var(--found)", "position"), key("var(--odometry)", "extent (2-Wasserstein)")),
    overall.matches.length ? lineChart([{name: "position, %", points: cut(position), color: "var(--found)", step: true},
      {name: "extent, %", points: cut(extent), color: "var(--odometry)", step: true}], {x: "m", y: "% of found", yMax: 100, xMax}) : el("p", {class: "none"}, "nothing was found"));
}

function calibrationCard() {
  const c = overall.calibration;
  const points = [[0, 0], ...c.inside.map((share, k) => [5 * (k + 1), isNumber(share) ? 100 * share : null])];
  const verdict = !isNumber(c.mean_over_3) ? "" : c.inside_90 < 0.8 ? "The map trusts itself too much." : c.inside_90 > 0.98
    ? "The map trusts itself too little." : "The map keeps its word.";
  return card("", "Calibration", `Share of found objects whose true position lies inside the region that should hold so many. ${verdict}`,
    legend(key("var(--found)", `measured (mean normalised square / 3: ${show(c.mean_over_3)}, median / 3: ${show(c.median_over_3)}; mean sigma: ${show(c.mean_sigma)} m)`), key("var(--muted)", "honest", "dash")),
    c.count ? lineChart([{name: "inside, %", points, color: "var(--found)", dots: true}],
      {x: "expected, %", y: "inside, %", xMax: 100, yMax: 100, diagonal: true}) : el("p", {class: "none"}, "nothing was found"));
}

function trajectoryCard() {
  const curve = (name, color) => scenery.errors[name] && {name, color, points: scenery.errors[name]};
  const row = (name, t) => t && el("tr", {}, el("td", {}, name), [t.ate_rmse, t.relative.translation_m_per_100m, t.relative.rotation_deg_per_100m]
    .map((x) => el("td", {}, show(x))), el("td", {}, percent(t.share)));
  const series = [curve("odometry", "var(--odometry)"), curve("corrected", "var(--corrected)")].filter(Boolean);
  return card("", "Trajectory", trajectory ? `Distance to the true pose after the best rigid fit; drift over stretches of ${show(trajectory.relative.stretch_m)} m.` : "",
    trajectory ? [legend(series.map((s) => key(s.color, s.name))), lineChart(series, {x: "frame", y: "m", height: 200}),
      el("table", {}, el("tr", {}, ["", "ATE, m", "drift, m / 100 m", "turn, deg / 100 m", "true poses scored"].map((h) => el("th", {}, h))),
        row("odometry", odometry), row("corrected", trajectory))] : el("p", {class: "none"}, "not scored: give --trajectory"));
}

function stageCard() {
  if (!cost) return card("third", "Time per stage", "", el("p", {class: "none"}, "the run left no stats.json"));
  const rows = Object.entries(cost.stage_ms).map(([name, t]) => ({name, value: t.p50, whisker: t.p99, text: `${show(t.p50)} / ${show(t.p99)} ms`,
    tip: `${name}\nmedian ${show(t.p50)}, 90 % ${show(t.p90)}, 99 % ${show(t.p99)}, max ${show(t.max)} ms`}));
  rows.push({name: "whole frame", value: cost.frame_ms.p50, whisker: cost.frame_ms.p99, color: "var(--muted)",
    text: `${show(cost.frame_ms.p50)} / ${show(cost.frame_ms.p99)} ms`});
  return card("third", "Time per stage", "Bar: median; whisker: 99 % of frames are faster.", barChart(rows, {rowHeight: 34}));
}

const curveOf = (list, value) => (list || []).map((s) => [s.frame, s[value]]);

function timeCard() {
  const mean = curveOf(cost && cost.time, "mean_ms");
  return card("", "Time per frame", "Must not grow with the map.", legend(key("var(--found)", "mean"), key("var(--found)", "slowest", "faint")),
    mean.length ? lineChart([{name: "slowest, ms", points: curveOf(cost.time, "max_ms"), color: "var(--found)", className: "faint"},
      {name: "mean, ms", points: mean, color: "var(--found)"}], {x: "frame", y: "ms"}) : el("p", {class: "none"}, "the run left no time curve"));
}

function memoryCards() {
  const list = (cost && cost.memory) || [];
  const chart = (title, note, value, color) => card("", title, note,
    list.length ? lineChart([{name: "MB", points: curveOf(list, value), color}], {x: "frame", y: "MB", height: 200}) : el("p", {class: "none"}, "the run left no memory curve"));
  return [chart("Map size", "Nodes, leaves, index and trajectory, estimated.", "map_mb", "var(--found)"),
    chart("Memory of the process", "Resident, everything included.", "rss_mb", "var(--corrected)")];
}

function geometryCard() {
  const rows = geometry && [["map accuracy", "estimate to reference", geometry.accuracy, "var(--found)"], ["completeness", "reference to estimate", geometry.completeness, "var(--corrected)"],
    ["Chamfer", "mean of both", geometry.chamfer, "var(--muted)"]].map(([name, about, value, color]) => ({name, value, color, text: `${show(value)} m`, tip: about}));
  return card("third", "Geometry", geometry ? `Points of the leaves against the reference cloud, cropped to 3 m around the estimate, aligned, without vegetation: ${geometry.estimate_points.toLocaleString("en")} against ${geometry.reference_points.toLocaleString("en")} points. The map covers ${percent(geometry.coverage)} of the reference along the path; ${percent(geometry.left_out)} of its leaves are too far from the path and left out.` : "",
    geometry ? barChart(rows, {rowHeight: 34}) : el("p", {class: "none"}, "not yet: the truth has no cloud.ply"));
}

function retrievalCard() {
  const rows = retrieval && [1, 2, 3].map((k) => ({name: `R@${k}`, value: retrieval["r" + k], text: percent(retrieval["r" + k])}));
  return card("third", "Retrieval", retrieval ? `${retrieval.queries} queries with one right answer each; ${retrieval.mapped} of their targets are in the map.` : "",
    retrieval ? barChart(rows, {max: 1, rowHeight: 34, left: 60}) : el("p", {class: "none"}, "not yet: no answers were given"));
}

const twinRows = (line, at) => (data.twins || []).map((t) => {
  const p = scenery.predictions.find((q) => q.id === t.ids[0]);
  return line(p, `twins, nodes ${t.ids.join(" and ")}`, `${show(t.distance)} m apart`, at(p));
});

function listCard() {
  const line = (o, what, value, at) => {
    const row = el("tr", {class: "hover"}, el("td", {}, o.name), el("td", {class: "left"}, what), el("td", {}, value), el("td", {}, at));
    row.addEventListener("click", () => showAt(o.mean[0], o.mean[1]));
    return row;
  };
  const at = (o) => o.mean.slice(0, 2).map((v) => v.toFixed(1)).join(", ");
  const worst = scenery.predictions.filter((p) => p.state === "found").sort((a, b) => b.distance - a.distance).slice(0, 8);
  const rows = [
    ...scenery.truth.filter((t) => t.state === "missed").map((t) => line(t, `missed, object ${t.id}`, `${t.points} points, ${t.frames} frames`, at(t))),
    ...scenery.predictions.filter((p) => p.state === "ghost").map((p) => line(p, `ghost, node ${p.id}`, `${CAUSES[p.cause] || ""}, evidence ${show(p.kappa)}`, at(p))),
    ...twinRows(line, at),
    ...worst.map((p) => line(p, `found, node ${p.id}`, `${show(p.distance)} m off`, at(p)))].slice(0, 400);
  return card("wide", "What to look at", "Missed objects, ghosts, twins, and the found objects farthest off. Click a row to see it on the map.",
    el("div", {class: "scroll tall"}, el("table", {}, el("tr", {}, ["class", "what", "", "x, y in m"].map((h, i) => el("th", {class: i === 1 ? "left" : ""}, h))), rows)));
}

document.title = data.title;
document.querySelector("main").replaceChildren(
  el("header", {}, el("div", {}, el("h1", {}, data.title), el("p", {class: "sub"},
    `${overall.truth} true objects, ${overall.predicted} in the map` + (cost ? `, ${cost.frames} frames` : "") +
    (overall.truth ? `. Found ${overall.true_positives}, missed ${overall.missed.length}, ${overall.ghosts.length} ghosts.` : "."))), themeButton()),
  tiles(), el("div", {class: "grid"}, mapCard(), classCard(), errorCard(), calibrationCard(), trajectoryCard(), timeCard(),
    stageCard(), geometryCard(), retrievalCard(), memoryCards(), listCard()),
  el("footer", {}, "Made by hgg-eval; everything is in this one file."));
document.body.append(tip);
