"""Flags of estimates: the checks that an estimate, or the record behind it, failed."""

# flag -> its meaning for an estimate, and what to check
FLAGS = {
    "at-bound": "a parameter lies at a bound of its search. Widen the bound, or check units and signs",
    "assumed": "the record does not determine the value, which is assumed. See the rows of its range",
    "relaxation-assumed": "a part of the stiffness relaxes at assumed rates, on which the value depends. Try "
    "other relaxation_times_s",
    "not-converged": "the fit stopped before it converged. Try other starting values",
    "undefined": "the value is not a finite number. The parameters describe no stable joint",
    "no-interval": "the standard error or interval is not a number. Record more perturbations",
    "leg-disagrees": "K of the windowed fit and K of the joint likelihood disagree. Look for markers of the "
    "leg that wobble, bend or slip",
    "foot-leg-delay": "the leg moves too early or too late after the foot. Check the sampling instants of "
    "the markers, and whether one on foot or ankle slips",
    "joint-inertia": "I differs from the known inertia of the joint. Weigh the leg, and find its centre of "
    "mass",
    "foot-markers-apart": "markers on the foot move against each other. Check their tape, and whether the "
    "foot tilts",
    "camera-scale": "the markers of the leg are further apart or closer than their layout by more than 1 %. "
    "Check the calibration of the cameras, and measure the layout again",
    "markers-slip": "a marker stays displaced after perturbations. Check the tape of all markers",
    "markers-pulse-locked": "markers leave the rigid leg in every perturbation. Look for bending or soft "
    "mounts",
    "lack-of-fit": "the model of the joint leaves a repeated motion or a large part of the signal "
    "unexplained. Inspect the residuals for wobble, hysteresis and wrong time stamps",
    "log-delay": "the log was early or late against the other instrument by more than 2 ms (torque) or 6 ms "
    "(belt), and was corrected. Check the trigger",
    "torque-delay": "the torque was recorded more than 1 ms before or after the movement that causes it, or "
    "one of the two was filtered. The fit does not correct this. Check triggers and filters",
    "filtered-signal": "a signal was filtered before it was recorded, and the other was not. Export both "
    "without a filter, or filter both alike",
    "joints-exchanged": "torques follow the angle of the other joint, or the slow torque of the hip exceeds "
    "the ankle's. Check the columns of ankle and hip, and that the angle of the hip is relative to the leg",
    "spikes": "single samples lie far from their neighbours. Remove them, and check cables",
    "held-samples": "values are held and then jump. Look for lost samples, or a slower clock",
    "clipped": "peaks are cut off at one value. Choose a larger range of the instrument",
    "other-amplitude": "the commanded belt is more than a quarter faster, or a fifth slower, than the "
    "amplitude in the trial sheet. Check that the file is the one of this trial",
    "calibration-differs": "the force plate has another calibration in this recording than in those of "
    "weight and empty belt. Use one calibration matrix for all; tepsipe check names what differs",
    "other-calibration": "the calibration of the force plate differs from that of weight and empty belt by "
    "more than 5 mm or 3 %, so no K of a person is recommended. Use one calibration matrix for all; tepsipe "
    "check names what differs",
    "plates-exchanged": "the load of the left plate acts to the right of the right plate's. Exchange the "
    "rows of both in the calibration matrix or the plates of the recording, or give their moments about the "
    "origin of the markers",
    "trials-differ": "K or B of one trial of the task differs from the others by more than a quarter and "
    "chance. Nothing is recommended beyond 40 %. Check its row of the trial sheet and its recording",
    "muscles-exchanged": "a muscle responds more when it is shortened than when it is stretched. Check the "
    "channels of the electromyograms",
    "emg-trigger": "the muscles respond earlier than a reflex can, or much later. Check the trigger of the "
    "electromyograms",
    "halves-differ": "the first and the second part of the record do not agree: the joint or the recording "
    "changed. Check mounts, sensors and the subject",
    "time-varying": "the stiffness differs between segments of the record by more than chance, so nothing is "
    "recommended. Analyse the parts separately, or name a schedule or trigger",
    "stamp-jitter": "time stamps of the log are random by more than 1.2 ms. Stamp samples when they are "
    "taken",
    "noise-biased": "noise of the markers biases the estimate. Record more, equal or larger perturbations, "
    "place markers further apart, or use the joint likelihood of a dummy",
    "pre-reflex-differs": "K differs from K of the pre-reflex window by more than 5 % and more than chance. "
    "Check the onset of the reflexes and the friction of the belt",
    "window-sensitive": "K changes by more than 25 % between windows. Check the onset of the "
    "reflexes and the treadmill model",
    "skin-motion": "soft tissue of the shank moves over the bone by more than can be corrected. Fasten the "
    "markers of the shank to bony places",
    "muscle-left-out": "a muscle that acts at the ankle has no usable electromyogram, so its torque counts "
    "as stiffness and damping. Repair its electrode, or quote another estimator",
    "few-perturbations": "more than 30 % of the perturbations are unusable. Read the reasons, and repeat the "
    "trial",
    "not-identified": "the perturbation does not determine the quantity, so it has no value. Record a "
    "second, independent perturbation",
    "no-response": "the angle does not respond to the perturbation. Perturb more, or more often",
    "no-contact": "the foot is in the air, so the belt does not perturb its joint. Perturb in stance",
    "coherent-residual": "the model leaves torque that is coherent with the platform, so it is too simple. "
    "Do not quote its parameters",
    "edge-of-search": "the onset lies at an end of its search range. Widen the range",
    "reflex-outside-search": "reflex delays or thresholds outside the searched range predict the torque at "
    "least as well as the one used. Measure the reflex delay, for example by electromyography, and enter it "
    "as reflex_delays_s in the configuration. A reflex takes at least 30 ms, so do not widen the range to "
    "shorter delays",
    "stretch-threshold": "the true latency may be more than 5 ms shorter, because responses begin later "
    "after smaller pulses, or because the pulses cannot show whether the reflex needs a fast stretch. Record "
    "pulses of several amplitudes",
    "reflex-not-determined": "the reflex torque does not clearly exceed its uncertainty, or its start is "
    "uncertain. Record more or larger perturbations",
    "slow-reflex": "the fitted muscle is slower than 1.9 Hz, so the response is more than a reflex. Do not "
    "quote its gain",
    "mass-differs": "the mass estimated from the fore-aft force differs from the trial sheet. Check the "
    "mass, the scale of the force, and friction and mounts of the belt",
    "diverged": "the prediction grows without limit. The parameters describe no stable joint",
    "treadmill-model": "the treadmill model fails: on held-out trials it may bias K by more than a tenth, or "
    "its constants are impossible. Record the empty belt and a weight close to the mass of the dummy or "
    "person, with the same pulses",
    "treadmill-not-converged": "the search for the constants of the treadmill model did not converge, and "
    "the model may bias K by more than a tenth, or its constants are impossible. Inspect the calibration "
    "trials one by one for slip of the weight, clipped channels and a wrong mass",
    "plate-origin": "in quiet standing the centre of pressure is more than 4 cm from the person's centre of "
    "mass. Check the origin of the force plate, or state where the weight's centre of mass lies",
    "plate-scale": "the force plate and the weights give different vertical forces. Check the scale of the "
    "plate, and the masses of the weights",
    "plate-transducer": "the force plate and the weights give different vertical forces, at different "
    "places. Check the gain of every transducer",
    "negative": "B or K is negative, which no joint has. Check signs, clocks and delays of the recording",
    "uncompensated": "no weight was recorded on the treadmill, so the belt-induced load is part of the "
    "torque. Record the empty belt, and a weight near the subject's mass",
    "frame-resonance": "the frame of the treadmill resonates lower under the person than when empty, as it "
    "does under a weight, although a person's force passes through the empty frame. Record a weight of the "
    "person's mass with the same pulses",
    "beyond-calibrated-mass": "the subject is heavier than every weight of the treadmill's calibration. "
    "Record a weight near the subject's mass",
}
# pathways that are shown for comparison only, and why
COMPARED = {
    "single-joint": "one inverted pendulum does not describe a standing person; included to show this",
    "foot": "the belt-induced load is not subtracted",
    "foot-long": "the belt-induced load is not subtracted",
    "ankle": "the belt-induced load is not subtracted",
}
