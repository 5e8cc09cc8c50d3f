function [parameters, verdict] = read_identification(folder)
% Names, values, standard errors and units of the parameters in a folder of results; NaN: not determined by the log.
  file = jsondecode(fileread(fullfile(folder, 'identification.json')));
  assert(file.format == 3, 'identification.json has format %d; this reader knows 3', file.format);
  first = @(list) list(1);  get = @(list, k) list(k);
  if iscell(file.results), first = @(list) list{1}; end
  result = first(file.results);  verdict = result.verdict;  rows = result.parameters;
  if iscell(rows), get = @(list, k) list{k}; end
  for k = numel(rows):-1:1
    row = get(rows, k);  parameters(k) = struct('name', row.name, 'value', NaN, 'standard_error', NaN, 'unit', row.unit);
    for key = {'value', 'standard_error'}
      if isfield(row, key{1}) && ~isempty(row.(key{1})), parameters(k).(key{1}) = row.(key{1}); end
    end
  end
end
