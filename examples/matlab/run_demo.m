% Runs the demo of sprung from MATLAB or GNU Octave and reads its parameters.
addpath(fileparts(mfilename('fullpath')));
assert(system('sprung demo --out sprung-demo > sprung-demo.txt') == 0, 'sprung failed');
[parameters, verdict] = read_identification(fullfile('sprung-demo', 'sprung-out'));
fprintf('verdict: %s\n', verdict);
for p = parameters
  fprintf('%-24s %12.5g +- %-10.2g %s\n', p.name, p.value, p.standard_error, p.unit);
end
