% Parallel-cascade models of the toolbox NLID, fitted to one part of a record and simulated over all of it.
%
% Called by run.py and enter_with_nlid.py with six arguments: folder of the toolbox, table of the record (angle and torque, as
% recorded, one line per sample), sampling rate (Hz), first and last sample that are fitted, folder for results.
% Further arguments are the names of the models that are wanted; without any, all are fitted.
% For every model it writes <model>.txt there: time (s) and simulated torque, one line per sample of the
% decimated record; <model>-intrinsic.txt: the same of the intrinsic pathway alone; and models.txt: model, and
% the reason where it could not be fitted.
%
% Uses public functions of the toolbox only, with its defaults but for the method of the reflex pathway and
% the rate after decimation: 100 Hz, the toolbox's own, and 200 Hz.

arguments = argv();
[toolbox, table, folder] = arguments{[1, 2, 6]};
rate = str2double(arguments{3});
fitted = str2double(arguments{4}):str2double(arguments{5});
wanted = arguments(7:end);

warning('off', 'all');
for name = {'signal', 'statistics', 'control'}
  try
    pkg('load', name{1});
  catch
    % a model that needs it fails with the reason
  end
end
for part = {'nlid_tools', fullfile('nlid_tools', 'nlid_util'), 'utility_tools', 'stiffnessID'}
  addpath(fullfile(toolbox, part{1}));
end

record = dlmread(table);
samples = rows(record);
training = nldat(record(fitted, :), 'domainIncr', 1 / rate);
angle_mean = mean(record(fitted, 1));
log = fopen(fullfile(folder, 'models.txt'), 'w');

for decimated = [100, 200]
  ratio = max(1, round(rate / decimated));
  % inputs of the simulation, prepared as for the fit but over the whole record
  angle = decimate(nldat(record(:, 1) - angle_mean, 'domainIncr', 1 / rate), ratio);
  velocity = decimate(ddt(nldat(record(:, 1), 'domainIncr', 1 / rate)), ratio);
  % a ramp shows which samples decimation keeps; its filter has a gain, and distorts the ends
  ramp = decimate(nldat((0:samples - 1)' / rate, 'domainIncr', 1 / rate), ratio);
  gain = median(double(decimate(nldat(ones(samples, 1), 'domainIncr', 1 / rate), ratio)));
  grid = ratio / rate * (0:numel(double(ramp)) - 1)';
  time = grid + median(double(ramp) / gain - grid);
  for method = {'rect', 'hk', 'sls'}
    model = sprintf('pc-%s-%dHz', method{1}, decimated);
    if ~isempty(wanted) && ~any(strcmp(model, wanted))
      continue
    end
    reason = '';
    rand('seed', 1);
    randn('seed', 1);
    try
      [intrinsic, reflex] = PC_stiffnessID(training, 'reflex_id_method', method{1}, 'decimation_ratio', ratio);
      drive = velocity;
      if strcmp(method{1}, 'rect')
        drive = max(velocity, 0);
      end
      own = double(nlsim(intrinsic, angle));
      torque = own + double(nlsim(reflex, drive));
      dlmwrite(fullfile(folder, [model '-intrinsic.txt']), [time, own(:)], 'delimiter', ' ', 'precision', '%.9g');
      dlmwrite(fullfile(folder, [model '.txt']), [time, torque(:)], 'delimiter', ' ', 'precision', '%.9g');
    catch failure
      reason = strrep(failure.message, "\n", ' ');
    end
    fprintf(log, '%s\t%s\n', model, reason);
  end
end
fclose(log);
