// Makes two_frames.db3: a ROS 2 bag in SQLite storage whose messages are written by a writer that is not ours.
//   npm install @foxglove/rosmsg2-serialization@3 @foxglove/rosmsg-msgs-common@3 sql.js@1 && node make_ros2_bag.mjs two_frames.db3
import { createRequire } from "node:module";
import { writeFileSync } from "node:fs";
const require = createRequire(process.cwd() + "/");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");
const { ros2humble } = require("@foxglove/rosmsg-msgs-common");
const initSqlJs = require("sql.js");

const NAMES = {
  cloud: "sensor_msgs/PointCloud2", odometry: "nav_msgs/Odometry", tf: "tf2_msgs/TFMessage",
};
const definitions = (name) => {
  // The message and all that it holds.
  const found = new Map();
  const visit = (n) => {
    if (found.has(n)) return;
    const d = ros2humble[n];
    found.set(n, d);
    for (const f of d.definitions) if (f.isComplex) visit(f.type);
  };
  visit(name);
  return [...found.values()].map((d, k) => (k === 0 ? { definitions: d.definitions } : d));
};
const writers = Object.fromEntries(Object.entries(NAMES).map(([k, n]) => [k, new MessageWriter(definitions(n))]));
const stamp = (ns) => ({ sec: Number(ns / 1000000000n), nsec: Number(ns % 1000000000n) });
const header = (ns, frame_id) => ({ stamp: stamp(ns), frame_id });

const cloud = (ns, shift) => {
  const data = new Uint8Array(3 * 20);
  const view = new DataView(data.buffer);
  for (let k = 0; k < 3; ++k) {
    view.setFloat32(20 * k, 1 + k + shift, true);
    view.setFloat32(20 * k + 4, -2 * k, true);
    view.setFloat32(20 * k + 8, 0.5, true);
    view.setUint8(20 * k + 12, 40 + k); // label
    view.setUint32(20 * k + 16, 7 * k, true); // instance
  }
  const field = (name, offset, datatype) => ({ name, offset, datatype, count: 1 });
  return {
    header: header(ns, "os_lidar"), height: 1, width: 3,
    fields: [field("x", 0, 7), field("y", 4, 7), field("z", 8, 7), field("label", 12, 2), field("instance", 16, 6)],
    is_bigendian: false, point_step: 20, row_step: 60, data, is_dense: true,
  };
};
const covariance = new Float64Array(36);
const odometry = (ns, x) => ({
  header: header(ns, "odom"), child_frame_id: "base_link",
  pose: { pose: { position: { x, y: 0.25, z: -0.125 }, orientation: { x: 0, y: 0, z: 0.6, w: 0.8 } }, covariance },
  twist: { twist: { linear: { x: 1, y: 0, z: 0 }, angular: { x: 0, y: 0, z: 0 } }, covariance },
});
const transform = {
  transforms: [{
    header: header(0n, "base_link"), child_frame_id: "os_lidar",
    transform: { translation: { x: 0.5, y: 0, z: 1 }, rotation: { x: 0, y: 0, z: 1, w: 0 } },
  }],
};

const SQL = await initSqlJs();
const db = new SQL.Database();
db.run(`CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
        offered_qos_profiles TEXT NOT NULL)`);
db.run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL)");
const topics = { "/points": "cloud", "/odom": "odometry", "/tf_static": "tf" };
Object.entries(topics).forEach(([name, kind], k) =>
  db.run("INSERT INTO topics VALUES(?,?,?,'cdr','')", [k + 1, name, NAMES[kind].replace("/", "/msg/")]));
const START = 1700000000123456000n;
const put = (topic, ns, message) =>
  db.run(`INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ${ns}, ?)`,
         [Object.keys(topics).indexOf(topic) + 1, writers[topics[topic]].writeMessage(message)]);
put("/tf_static", START, transform);
for (const k of [0n, 1n]) {
  const ns = START + k * 100000000n;
  put("/odom", ns, odometry(ns, 2 * Number(k)));
  put("/points", ns, cloud(ns, Number(k)));
}
writeFileSync(process.argv[2], db.export());
