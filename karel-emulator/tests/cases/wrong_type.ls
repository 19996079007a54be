/PROG  WRONG_TYPE
/ATTR
OWNER = MNEDITOR;
/MN
   1:  SR[1]='text'    ;
   2:  DO[1]=SR[1]    ;
/POS
/END
