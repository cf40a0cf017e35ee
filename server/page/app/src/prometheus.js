// The text format of /metrics.

/** name -> [{labels: {..}, value}, ..] */
export function readMetrics(text) {
  const found = new Map();
  for (const line of text.split("\n")) {
    const [, name, labels, value] = line.match(/^([a-zA-Z_:][\w:]*)(?:\{(.*)\})? (\S+)/) || [];
    if (!name) continue;
    const pairs = [...(labels || "").matchAll(/(\w+)="((?:[^"\\]|\\.)*)"/g)].map(([, key, word]) => [key, word]);
    if (!found.has(name)) found.set(name, []);
    found.get(name).push({labels: Object.fromEntries(pairs), value: Number(value.replace("Inf", "Infinity"))});
  }
  return found;
}

/** The sum over all labels that hold what `wanted` says. */
export function sum(metrics, name, wanted = {}) {
  return (metrics.get(name) || []).filter(({labels}) => Object.entries(wanted).every(([key, word]) => labels[key] === word))
    .reduce((total, {value}) => total + value, 0);
}

/** The limit of the bucket that holds this share of a histogram's values; null without any. Buckets are [{limit, count}], cumulative. */
export function quantile(buckets, share) {
  const all = buckets.at(-1)?.count || 0;
  return all ? buckets.find(({count}) => count >= share * all).limit : null;
}

/** The buckets of a histogram, added over the series that `wanted` chooses, less those of `before`. */
export function buckets(metrics, name, wanted = {}, before = null) {
  const counts = new Map();
  for (const [from, sign] of [[metrics, 1], [before, -1]]) {
    for (const {labels, value} of from?.get(`${name}_bucket`) || []) {
      if (Object.entries(wanted).some(([key, word]) => labels[key] !== word)) continue;
      const limit = labels.le === "+Inf" ? Infinity : Number(labels.le);
      counts.set(limit, (counts.get(limit) || 0) + sign * value);
    }
  }
  return [...counts].sort(([a], [b]) => a - b).map(([limit, count]) => ({limit, count}));
}
