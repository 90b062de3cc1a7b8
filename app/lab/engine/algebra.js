/** Small dense matrices, row by row in flat arrays: eigenvectors, singular values, least squares.
 * @typedef {Float64Array} Matrix */

const SWEEPS = 30; // a bound: Jacobi's rotations converge quadratically, after 6 to 8 sweeps

/** Eigenvalues, ascending, and unit eigenvectors of a symmetric matrix, by Jacobi's rotations.
 * @param {Matrix} A n x n @param {number} n @returns {{values: number[], vectors: Float64Array[]}} */
export function symmetricEigen(A, n) {
  const a = Float64Array.from(A), v = identity(n);
  let trace = 0;
  for (let i = 0; i < n; i++) trace += Math.abs(a[i * n + i]);
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    let off = 0;
    for (let p = 0; p < n - 1; p++) for (let q = p + 1; q < n; q++) {
      const x = a[p * n + q];
      off += x * x;
      if (Math.abs(x) <= 1e-19 * trace) continue;
      const [c, s] = rotation(a[p * n + p], x, a[q * n + q]);
      for (let k = 0; k < n; k++) rotate(a, k * n + p, k * n + q, c, s);
      for (let k = 0; k < n; k++) rotate(a, p * n + k, q * n + k, c, s);
      for (let k = 0; k < n; k++) rotate(v, k * n + p, k * n + q, c, s);
    }
    if (off <= 1e-34 * trace * trace) break;
  }
  const order = Array.from({length: n}, (_, k) => k).sort((i, j) => a[i * n + i] - a[j * n + j]);
  return {
    values: order.map(k => a[k * n + k]),
    vectors: order.map(k => Float64Array.from({length: n}, (_, i) => v[i * n + k])),
  };
}

/** X = U diag(sigma) Vᵀ with sigma descending, by one-sided Jacobi rotations (Hestenes 1958).
 * @param {Matrix} X rows x columns, with at least as many rows as columns @param {number} rows
 * @param {number} columns
 * @returns {{U: Matrix, sigma: number[], V: Matrix}} U: rows x columns, zero where sigma is; V: columns x columns */
export function svd(X, rows, columns) {
  const x = Float64Array.from(X), v = identity(columns);
  for (let sweep = 0, turned = true; turned && sweep < SWEEPS; sweep++) {
    turned = false;
    for (let p = 0; p < columns - 1; p++) for (let q = p + 1; q < columns; q++) {
      let pp = 0, pq = 0, qq = 0;
      for (let i = 0; i < x.length; i += columns) {
        pp += x[i + p] * x[i + p]; pq += x[i + p] * x[i + q]; qq += x[i + q] * x[i + q];
      }
      if (Math.abs(pq) <= 1e-16 * Math.sqrt(pp * qq)) continue;
      turned = true;
      const [c, s] = rotation(pp, pq, qq);
      for (let i = 0; i < rows; i++) rotate(x, i * columns + p, i * columns + q, c, s);
      for (let i = 0; i < columns; i++) rotate(v, i * columns + p, i * columns + q, c, s);
    }
  }
  const length = Array.from({length: columns}, (_, k) => {
    let sum = 0;
    for (let i = k; i < x.length; i += columns) sum += x[i] * x[i];
    return Math.sqrt(sum);
  });
  const order = length.map((_, k) => k).sort((i, j) => length[j] - length[i]);
  const U = new Float64Array(x.length), V = new Float64Array(v.length);
  order.forEach((from, to) => {
    for (let i = 0; i < rows; i++) U[i * columns + to] = length[from] > 0 ? x[i * columns + from] / length[from] : 0;
    for (let i = 0; i < columns; i++) V[i * columns + to] = v[i * columns + from];
  });
  return {U, sigma: order.map(k => length[k]), V};
}

/** The X for which |A X - B| is least, by Householder's reflections.
 * @param {Matrix} A rows x n, of rank n @param {Matrix} B rows x k @param {number} n @param {number} k
 * @returns {Matrix} n x k */
export function leastSquares(A, B, n, k) {
  const rows = A.length / n, wide = n + k, R = new Float64Array(rows * wide), reflector = new Float64Array(rows);
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j < n; j++) R[i * wide + j] = A[i * n + j];
    for (let j = 0; j < k; j++) R[i * wide + n + j] = B[i * k + j];
  }
  for (let c = 0; c < n; c++) {
    let norm = 0;
    for (let i = c; i < rows; i++) norm += R[i * wide + c] ** 2;
    const alpha = R[c * wide + c] > 0 ? -Math.sqrt(norm) : Math.sqrt(norm);
    let square = 0;
    for (let i = c; i < rows; i++) {
      reflector[i] = R[i * wide + c] - (i === c ? alpha : 0);
      square += reflector[i] ** 2;
    }
    if (square > 0) for (let j = c; j < wide; j++) {
      let along = 0;
      for (let i = c; i < rows; i++) along += reflector[i] * R[i * wide + j];
      for (let i = c; i < rows; i++) R[i * wide + j] -= 2 * along / square * reflector[i];
    }
  }
  const X = new Float64Array(n * k);
  for (let j = 0; j < k; j++) for (let i = n - 1; i >= 0; i--) {
    let sum = R[i * wide + n + j];
    for (let c = i + 1; c < n; c++) sum -= R[i * wide + c] * X[c * k + j];
    X[i * k + j] = sum / R[i * wide + i];
  }
  return X;
}

/** Solve A x = b for a small square A, by elimination with partial pivoting.
 * @param {number[][]} A @param {number[]} b @returns {number[]} */
export function solve(A, b) {
  const n = b.length, rows = A.map((row, i) => [...row, b[i]]);
  for (let c = 0; c < n; c++) {
    let pivot = c;
    for (let i = c + 1; i < n; i++) if (Math.abs(rows[i][c]) > Math.abs(rows[pivot][c])) pivot = i;
    [rows[c], rows[pivot]] = [rows[pivot], rows[c]];
    for (let i = c + 1; i < n; i++) {
      const factor = rows[i][c] / rows[c][c];
      for (let j = c; j <= n; j++) rows[i][j] -= factor * rows[c][j];
    }
  }
  const x = new Array(n).fill(0);
  for (let i = n - 1; i >= 0; i--) {
    let sum = rows[i][n];
    for (let j = i + 1; j < n; j++) sum -= rows[i][j] * x[j];
    x[i] = sum / rows[i][i];
  }
  return x;
}

export const DEGREE = Math.PI / 180;

/** Degrees, of the joint that is farthest. @param {ArrayLike<number>} a @param {ArrayLike<number>} b rad */
export const farthest = (a, b) => Math.max(...Array.from(a, (v, k) => Math.abs(v - b[k]))) / DEGREE;

/** @typedef {[number, number, number]} Vector @param {ArrayLike<number>} a @param {ArrayLike<number>} b @returns {Vector} */
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** Of length 1. @param {number[]} v */
export const unit = v => v.map(x => x / Math.hypot(...v));

/** @param {ArrayLike<number>} a @param {ArrayLike<number>} b */
export function dot(a, b) {
  let sum = 0;
  for (let i = 0; i < a.length; i++) sum += a[i] * b[i];
  return sum;
}

/** @param {number[]} values */
export const largest = values => Math.max(...values.map(Math.abs));

/** @param {number} value @param {number} low @param {number} high */
export const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

/** Cosine and sine of the rotation that makes [[a, b], [b, d]] diagonal. @param {number} a @param {number} b @param {number} d */
function rotation(a, b, d) {
  const cotangent = (d - a) / (2 * b);
  const tangent = (cotangent < 0 ? -1 : 1) / (Math.abs(cotangent) + Math.sqrt(1 + cotangent * cotangent));
  const cosine = 1 / Math.sqrt(1 + tangent * tangent);
  return [cosine, tangent * cosine];
}

/** @param {Matrix} m @param {number} i @param {number} j @param {number} c @param {number} s */
function rotate(m, i, j, c, s) {
  const a = m[i], b = m[j];
  m[i] = c * a - s * b;
  m[j] = s * a + c * b;
}

/** @param {number} n */
function identity(n) {
  const I = new Float64Array(n * n);
  for (let i = 0; i < n; i++) I[i * n + i] = 1;
  return I;
}

/** @param {number[]} values */
export function median(values) {
  const ordered = [...values].sort((a, b) => a - b), middle = (ordered.length - 1) / 2;
  return (ordered[Math.floor(middle)] + ordered[Math.ceil(middle)]) / 2;
}
