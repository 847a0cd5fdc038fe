"""The two programs a study runs: the generator, and what is tested."""
import hashlib
import json
import pathlib
import subprocess
import time


class Programs:
    def __init__(self, binaries, timeout_s=900):
        self.generator = pathlib.Path(binaries) / 'sagitta_hidden_generator'
        self.sagitta = pathlib.Path(binaries) / 'sagitta'
        self.timeout_s = timeout_s

    def fingerprint(self):
        return hashlib.sha256(self.sagitta.read_bytes()).hexdigest()[:16]

    def generate(self, flags, folder, answer):
        command = [str(self.generator), '--out=%s' % folder, '--answer=%s' % answer]
        command += ['--%s=%s' % (k, v) if v is not None else '--%s' % k for k, v in flags.items()]
        subprocess.run(command, check=True, capture_output=True, text=True)

    def displace(self, source, target, kind, scale, seed, number):
        """Where an effect would move the points of an arm that was really measured."""
        subprocess.run([str(self.generator), '--displacements=%s' % source, '--out=%s' % target, '--kinds=%s' % kind,
                        '--scales=%.9g' % scale, '--study=%d' % seed, '--case=%d' % number], check=True,
                       capture_output=True, text=True)

    def simulate(self, experiment, truth, seed, out):
        """An experiment's measurements from an estimate.json, with its noise."""
        subprocess.run([str(self.sagitta), 'simulate', str(experiment), '--truth=%s' % truth, '--seed=%s' % seed,
                        '--out=%s' % out, '--quiet'], check=True, capture_output=True, text=True)

    def predict(self, estimate, rows, out):
        subprocess.run([str(self.sagitta), 'predict', str(estimate), str(rows), '--out=%s' % out, '--quiet'], check=True,
                       capture_output=True, text=True)

    def calibrated(self, experiment, out):
        """estimate.json of an experiment; None where there is no estimate."""
        command = [str(self.sagitta), 'calibrate', str(experiment), '--out=%s' % out, '--quiet']
        done = subprocess.run(command, capture_output=True, text=True, timeout=self.timeout_s)
        path = pathlib.Path(out) / 'estimate.json'
        if done.returncode != 0 or not path.exists():
            return None
        return json.loads(path.read_text())

    def chi_square(self, experiment, out):
        """Noise-free chi-square on the calibration rows, latent deviations included; None: no estimate."""
        estimate = self.calibrated(experiment, out)
        return None if estimate is None else estimate['fit']['chi2']

    def diagnose(self, experiment, out, flags=()):
        """(diagnosis or None, message, seconds)"""
        command = [str(self.sagitta), 'diagnose', str(experiment), '--out=%s' % out, '--quiet', *flags]
        start = time.time()
        try:
            done = subprocess.run(command, capture_output=True, text=True, timeout=self.timeout_s)
        except subprocess.TimeoutExpired:
            return None, 'not finished after %g s' % self.timeout_s, time.time() - start
        path = pathlib.Path(out) / 'diagnosis.json'
        if done.returncode != 0 or not path.exists():
            return None, 'exit %d: %s' % (done.returncode, done.stderr.strip()[-500:]), time.time() - start
        return json.loads(path.read_text()), '', time.time() - start
